"""Reads a faulty description as it was probably meant, so that the rest of it can be judged."""

from __future__ import annotations

from copy import deepcopy
from typing import Any, get_origin

from pydantic import ValidationError

from end_effector_hal.description._fault import Fault, Keys, Place, Places, closest
from end_effector_hal.description._shape import fields_of, stanza_at, stanza_in, top_mappings
from end_effector_hal.description.model._channels import Channel
from end_effector_hal.description.model._description import Description
from end_effector_hal.kinds.stanza import NO_CHANNEL, BaseStanza


def read_as_meant(tree: dict[str, Any], places: Places) -> list[Fault]:
    """Rename each wrong top-level key in the tree and in the places, and return the faults of these keys.

    A key whose meaning is not clear stays, and is reported with all other faults.
    """
    found = []
    for key in sorted(tree, key=lambda key: isinstance(tree[key], list)):  # a list may name the actuators
        wrong = _link_for_links(key, tree, places) or _misspelt(key, tree, places)
        if wrong is not None:
            meant, fault = wrong
            found.append(fault)
            tree[meant] = tree.pop(key)
            _move(places.keys, key, meant)
            _move(places.values, key, meant)
    return found


def _move(places: dict[Keys, Place], key: str, meant: str) -> None:
    for path in [path for path in places if path[:1] == (key,)]:
        places[(meant, *path[1:])] = places.pop(path)


def _link_for_links(key: str, tree: dict[str, Any], places: Places) -> tuple[str, Fault] | None:
    """Return what was meant, and the fault: several named links under ``link``, or one link's keys under ``links``."""
    meant = {"link": "links", "links": "link"}.get(key)
    if (
        meant is None
        or meant in tree
        or not tree[key]
        or _fits(key, tree[key])
        or not _fits(meant, tree[key])
    ):
        return None
    inside = ", ".join(tree[key])
    what, expected = f"'link' has the keys of one link, and these are names ({inside})", "links: by name"
    if meant == "link":
        what, expected = f"'links' has links by name, and these are keys of one ({inside})", "link: one link"
    fault = Fault.at(places.key(key), "EE-228", what, found="", expected=expected, hint=f"write {meant}")
    return meant, fault


def _misspelt(key: str, tree: dict[str, Any], places: Places) -> tuple[str, Fault] | None:
    if key in fields_of(Description):
        return None
    value, free = tree[key], fields_of(Description).keys() - tree.keys()
    likely = closest(key, sorted(each for each in free if _fits(each, value)))
    if likely is None:  # by what stands in it, where that leaves no doubt
        alike = [each for each in top_mappings() if each in free and _is_one(each, value)]
        alike += ["sequence"] if "sequence" in free and _names_actuators(value, tree) else []
        likely = alike[0] if len(alike) == 1 else None
    if likely is None:
        return None
    found = f"{key}:" if isinstance(value, dict | list) else f"{key}: {places.value(key).text}"
    what, expected, hint = f"unknown key {key!r}", "a key of the description", f"did you mean {likely!r}?"
    return likely, Fault.at(places.key(key), "EE-205", what, found=found, expected=expected, hint=hint)


def _fits(key: str, value: object) -> bool:
    """Return whether a value looks like that of a top-level key, though parts of it may be wrong."""
    if mapping := top_mappings().get(key):
        known = set().union(*map(fields_of, mapping))
        inside = value.values() if isinstance(value, dict) else ()
        return any(isinstance(each, dict) and not known.isdisjoint(each) for each in inside)
    annotation = fields_of(Description)[key].annotation
    if model := stanza_in(annotation):
        return isinstance(value, dict) and (not value or not fields_of(model).keys().isdisjoint(value))
    return (
        value is not None and not isinstance(value, dict) and isinstance(value, list) == _is_list(annotation)
    )


def _is_list(annotation: Any) -> bool:
    return any(get_origin(each) is tuple for each in (annotation, *getattr(annotation, "__args__", ())))


def _names_actuators(value: object, tree: dict[str, Any]) -> bool:
    actuators = tree.get("actuators")
    known = [*actuators] if isinstance(actuators, dict) else []
    return isinstance(value, list) and bool(value) and all(each in known for each in value)


def _is_one(key: str, value: object) -> bool:
    """Return whether each stanza of a value has the keys of a top-level mapping, and no others."""
    models = top_mappings()[key]
    inside = [*value.values()] if isinstance(value, dict) else []
    return bool(inside) and all(
        isinstance(each, dict) and any(_has_its_keys(model, each) for model in models) for each in inside
    )


def _has_its_keys(model: type[BaseStanza], stanza: dict[str, Any]) -> bool:
    fields = fields_of(model)
    needed = {name for name, each in fields.items() if each.is_required()}
    return needed <= stanza.keys() <= fields.keys()


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
    model: type[BaseStanza] | None = stanza_at(path, kind)
    for key, field in fields_of(model).items() if model else ():
        if field.is_required() and key not in stanza and key != "kind":
            stanza[key] = 0 if field.annotation is int else NO_CHANNEL if key == "channel" else _UNREAD
