"""Rules of ownership: a line, a sensor and a ROS name belong to one device."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from end_effector_hal.description._fault import Fault, Keys
from end_effector_hal.description._shape import Facts
from end_effector_hal.description.model._description import camel_case
from end_effector_hal.description.model._stanzas import ToolChanger
from end_effector_hal.kinds import get_kind
from end_effector_hal.kinds.stanza import NO_CHANNEL, line_text
from end_effector_hal.signals import Kind

ROS = {"service": "Set", "topic": "Pressure"}
_MAY_BE_ONE = {("tool_changer", "locked_bit"), ("tool_changer", "present_bit")}
"""Two keys that may name the same sensor: a locked tool is present."""
_READ_BY_ACTUATORS = ("channel", "on", "verify", "ready", "taken")
"""Keys of an actuator whose channel may have a second reader, such as a sensor that two cups share."""


def shared_faults(facts: Facts) -> Iterator[Fault]:
    """Yield a fault for every second device on a line, channel, bit, service or topic."""
    changer: list[Keys] = [("tool_changer",)] if isinstance(facts.get("tool_changer"), dict) else []
    actuators: list[Keys] = [("actuators", name) for name, _ in facts.actuators()]
    kinds = [(name, get_kind(kind)) for name, kind in facts.actuators()]
    supply: list[Keys] = [("supply",)]
    e_stop: list[Keys] = [("e_stop",)] if isinstance(facts.get("e_stop"), dict) else []
    bits = [*_claims(changer, *ToolChanger.BITS), *_claims(supply, "channel"), *_claims(e_stop, "channel")]
    for name, kind in kinds:
        keys = [each.key for each in kind.channels if each.carries is Kind.BIT]
        bits += _claims([("actuators", name)], *(key for key in keys if _is_asked(facts, name, key)))
    outputs = facts.outputs()
    second: list[Keys] = [(*each, "opposite") for each in outputs if facts.written(*each, "opposite")]
    digital: list[Keys] = [("channels", name, "digital") for name in facts.names("channels")]
    digital = [each for each in digital if isinstance(facts.get(*each), dict)]
    yield from _called_like_an_actuator(facts)
    yield from _second(facts, "line", _claims([*outputs, *second, *digital], "line"))
    yield from _second(facts, "channel", _claims([*supply, *actuators], "channel"))
    yield from _second(facts, "bit", tuple(bits))
    if e_stop:
        yield from _reads_the_e_stop(facts)
    yield from _second(facts, "service", _claims([*changer, *actuators], "service"))
    yield from _second(facts, "topic", _claims(actuators, "topic"))


def _called_like_an_actuator(facts: Facts) -> Iterator[Fault]:
    taken = {name for name, _ in facts.actuators()}
    for name in facts.names("outputs"):
        if name in taken:
            what = f"the output is called like the actuator {name!r}"
            yield facts.key_fault(("outputs", name), "EE-221", what, "another name")


def _is_asked(facts: Facts, name: str, key: str) -> bool:
    """Return whether a bit is used: a default bit that `evidence` replaces is not."""
    return facts.get("actuators", name, "evidence") is None or facts.written("actuators", name, key)


def _reads_the_e_stop(facts: Facts) -> Iterator[Fault]:
    """Yield a fault for the first actuator that reads the e-stop's input.

    The actuator's signal would stop the tool, or the reverse.
    """
    e_stop: Keys = ("e_stop", "channel")
    channel = facts.get(*e_stop)
    if channel is None or channel == NO_CHANNEL:
        return
    readers = [
        path
        for path in facts.places.values
        if path[0:1] == ("actuators",) and path[-1] in _READ_BY_ACTUATORS and _raw(facts, path) == channel
    ]
    if readers:
        reader = min(readers, key=lambda each: facts.places.value(*each).order)
        yield from _second(facts, "bit", (reader, e_stop))


def _raw(facts: Facts, path: Keys) -> object:
    """Return the value at a path, which may lead through lists; None if a part of the path has a fault."""
    if any(path[:length] in facts.broken for length in range(1, len(path) + 1)):
        return None
    value: Any = facts.tree
    for key in path:
        try:
            value = value[key]
        except (KeyError, IndexError, TypeError):
            return None
    return value


def _claims(stanzas: list[Keys], *keys: str) -> tuple[Keys, ...]:
    return tuple((*stanza, key) for stanza in stanzas for key in keys)


def _second(facts: Facts, what: str, claims: tuple[Keys, ...]) -> Iterator[Fault]:
    owners: dict[object, Keys] = {}
    for path in sorted(claims, key=lambda each: facts.places.value(*each).order):
        value = _raw(facts, path) or facts.get(*path) or _ros_default(facts, path)
        value = line_text(value) if what == "line" else value
        if value is None or (value == NO_CHANNEL and what in ("channel", "bit")):
            continue
        if value not in owners:
            owners[value] = path
            continue
        owner = owners[value]
        if {owner, path} == _MAY_BE_ONE:
            continue
        device = owner[1] if owner[0] in ("actuators", "channels", "outputs") else owner[0]
        written = f"{path[-1]}: {value}" + ("" if facts.written(*path) else " (default)")
        sentence = f"{what} {value!r} already belongs to {str(device)!r}"
        hint = "an e-stop has an input of its own" if "e_stop" in (owner[0], path[0]) else ""
        yield facts.fault(path, "EE-221", sentence, f"a {what} of its own", hint=hint, found=written)


def _ros_default(facts: Facts, path: Keys) -> str | None:
    if path[0] != "actuators" or path[-1] not in ROS or path in facts.broken:
        return None
    return ROS[str(path[-1])] + camel_case(str(path[1]))
