"""Names of channels in the file of a device, which have the name of the actuator in front in a description."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, get_args, get_origin

from end_effector_hal.description._fault import Keys
from end_effector_hal.description._shape import fields_of, stanza_at
from end_effector_hal.errors import UsageError


def renamed(value: Any, names: Mapping[str, str], path: Keys, kind: str) -> Any:
    """Return a copy of a value of an actuator's stanza with the names that the description has.

    Args:
        value: a value, or a whole stanza.
        names: the names in the description by those in the file.
        path: where the value stands in the description.
        kind: the kind of the actuator.
    """
    if isinstance(value, dict):
        return {key: renamed(each, names, (*path, key), kind) for key, each in value.items()}
    if isinstance(value, list):
        return [renamed(each, names, (*path, index), kind) for index, each in enumerate(value)]
    if isinstance(value, str) and value in names and not _is_choice(path, kind):
        return names[value]
    return value


def _is_choice(path: Keys, kind: str) -> bool:
    """Return whether a key allows only certain words, so that its value is not the name of a channel."""
    keys = [each for each in path if not isinstance(each, int)]
    if keys[-1] == "kind":
        return True
    try:
        stanza = stanza_at(tuple(keys[:-1]), kind)
    except UsageError:  # an unknown kind
        return False
    found = fields_of(stanza).get(str(keys[-1])) if stanza else None
    return found is not None and _has_choices(found.annotation)


def _has_choices(annotation: Any) -> bool:
    return get_origin(annotation) is Literal or any(
        _has_choices(each) for each in get_args(annotation) if not isinstance(each, str)
    )
