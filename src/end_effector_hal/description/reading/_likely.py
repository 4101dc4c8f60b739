"""Builds a faulty description with defaults for its faulty values, so that the rest of it can be judged."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

from pydantic import ValidationError

from end_effector_hal.description._fault import Keys, Places
from end_effector_hal.description._shape import fields_of, stanza_at
from end_effector_hal.description.model._channels import Channel
from end_effector_hal.description.model._description import Description
from end_effector_hal.kinds.stanza import NO_CHANNEL, Part

_UNREAD = "unread"
"""Placeholder for a required text that is faulty."""


def likely(tree: dict[str, Any], places: Places, broken: set[Keys]) -> Description | None:
    """Return the description without its faulty values; None if no actuator or no link is left."""
    tree = deepcopy(tree)
    if not isinstance(tree.get("actuators"), dict) or not isinstance(tree.get("link", {}), dict):
        return None
    for path in sorted(broken, key=len, reverse=True):
        _remove(tree, path)
    tree.setdefault("name", _UNREAD)
    if "link" in tree:
        _fill(tree["link"], ("link",), "")
    for name, link in tree["links"].items() if isinstance(tree.get("links"), dict) else ():
        if isinstance(link, dict):
            _fill(link, ("links", name), "")
    for name, channel in tree["channels"].items() if isinstance(tree.get("channels"), dict) else ():
        for source in Channel.SOURCES if isinstance(channel, dict) else ():
            if isinstance(channel.get(source), dict):
                _fill(channel[source], ("channels", name, source), "")
    if isinstance(tree.get("tool_changer"), dict):
        _fill(tree["tool_changer"], ("tool_changer",), "")
    # the whole stanza is gone where one of its names is broken
    actuators = {name: each for name, each in tree.get("actuators", {}).items() if isinstance(each, dict)}
    for name, stanza in actuators.items():
        _fill(stanza, ("actuators", name), str(stanza["kind"]))
    sequence = tree.get("sequence")
    named = [str(name) for name in sequence if str(name) in actuators] if isinstance(sequence, list) else []
    every = list(dict.fromkeys([*named, *actuators]))
    tree |= {"actuators": actuators, "sequence": every, "release_order": None}
    try:
        found = Description.model_validate(tree, by_alias=True, by_name=False)
    except ValidationError:
        return None
    found._places = places
    return found


def _remove(tree: dict[str, Any], path: Keys) -> None:
    """Remove a faulty value; a list is removed as a whole, since its elements have no defaults."""
    at: Any = tree
    for key in path[:-1]:
        at = at.get(key) if isinstance(at, dict) else None
    if isinstance(at, dict) and path and path[-1] != "kind":
        at.pop(path[-1], None)


def _fill(stanza: dict[str, Any], path: Keys, kind: str) -> None:
    """Fill in each required key that is missing; an unknown channel becomes ``none``."""
    model: type[Part] | None = stanza_at(path, kind)
    for key, field in fields_of(model).items() if model else ():
        if field.is_required() and key not in stanza and key != "kind":
            stanza[key] = 0 if field.annotation is int else NO_CHANNEL if key == "channel" else _UNREAD
