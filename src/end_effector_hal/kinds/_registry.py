"""Kinds of devices by name: our own, and those that other distributions add by an entry point."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

from end_effector_hal.errors import UsageError
from end_effector_hal.plugins import Plugins

from ._checked import checked
from ._kind import DeviceKind
from .stanza import Actuator

GROUP = "end_effector_hal.kinds"
OWN = {
    "vacuum": "end_effector_hal.kinds.vacuum:Vacuum",
    "cylinder": "end_effector_hal.kinds.cylinder:Cylinder",
}


def kind_names() -> tuple[str, ...]:
    """All that `get_kind` knows, our own first."""
    return _KINDS.names


@cache
def get_kind(name: str) -> DeviceKind[Any]:
    """The kind of that name.

    Another distribution adds one by an entry point, a class or an object, in ``end_effector_hal.kinds``.

    Raises:
        UsageError: there is none of that name (with those that there are), or it cannot be loaded.
    """
    kind = _KINDS.get(name)
    if kind.name != name:
        raise UsageError(
            f"the entry point {name} names the kind {kind.name}.", todo="Both have the same name."
        )
    return kind


def kind_of(part: Actuator) -> DeviceKind[Any]:
    """The kind of an actuator."""
    return get_kind(part.kind)


@cache
def usable_kinds() -> Mapping[str, DeviceKind[Any]]:
    """Every kind that is installed and can be loaded, our own first; what cannot is only told when it is used."""
    found = {}
    for name in kind_names():
        try:
            found[name] = get_kind(name)
        except UsageError:
            continue
    return found


def recorded_kind(name: str, kinds: Mapping[str, str]) -> DeviceKind[Any]:
    """The kind of an actuator in a recording, from what its run.json says.

    A recording without run.json has names only: the kind whose name is part of the actuator's, else the first one,
    whose OFF and ON fit anything.

    Raises:
        UsageError: run.json names a kind that is not installed.
    """
    if recorded := kinds.get(name):
        return get_kind(recorded)
    return get_kind(next((kind for kind in OWN if kind in name), next(iter(OWN))))


_KINDS: Plugins[DeviceKind[Any]] = Plugins(GROUP, "kind of actuator", OWN, checked)
