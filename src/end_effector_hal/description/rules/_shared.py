"""Rules of ownership: a wire, a sensor and a ROS name belong to one device."""

from __future__ import annotations

from collections.abc import Iterator

from end_effector_hal.description._fault import Fault, Keys
from end_effector_hal.description._shape import Facts
from end_effector_hal.description.model import camel_case
from end_effector_hal.kinds import get_kind
from end_effector_hal.kinds.stanza import NO_CHANNEL
from end_effector_hal.signals import Kind

ROS = {"service": "Set", "topic": "Pressure"}


def shared_faults(facts: Facts) -> Iterator[Fault]:
    """Every second device on a line, channel, bit, service or topic."""
    changer: list[Keys] = [("tool_changer",)] if isinstance(facts.get("tool_changer"), dict) else []
    actuators: list[Keys] = [("actuators", name) for name, _ in facts.actuators()]
    kinds = [(name, get_kind(kind)) for name, kind in facts.actuators()]
    supply: list[Keys] = [("supply",)]
    bits = [*_claims(changer, "locked_bit", "unlocked_bit")]
    for name, kind in kinds:
        bits += _claims([("actuators", name)], *(k.key for k in kind.channels if k.carries is Kind.BIT))
    opposing: list[Keys] = [("actuators", name, kind.opposing) for name, kind in kinds if kind.opposing]
    opposing += [(*stanza, "opposite") for stanza in (*changer, *actuators)]
    opposing = [each for each in opposing if facts.written(*each)]
    digital: list[Keys] = [("channels", name, "digital") for name in facts.names("channels")]
    digital = [each for each in digital if isinstance(facts.get(*each), dict)]
    outputs: list[Keys] = [("outputs", name) for name in facts.names("outputs")]
    outputs = [each for each in outputs if isinstance(facts.get(*each), dict)]
    yield from _called_like_an_actuator(facts)
    yield from _second(facts, "line", _claims([*changer, *actuators, *opposing, *outputs, *digital], "line"))
    yield from _second(facts, "channel", _claims([*supply, *actuators], "channel"))
    yield from _second(facts, "bit", tuple(bits))
    yield from _second(facts, "service", _claims([*changer, *actuators], "service"))
    yield from _second(facts, "topic", _claims(actuators, "topic"))


def _called_like_an_actuator(facts: Facts) -> Iterator[Fault]:
    taken = {name for name, _ in facts.actuators()}
    for name in facts.names("outputs"):
        if name in taken:
            what = f"the output is called like the actuator {name!r}"
            yield Fault.at(
                facts.places.key("outputs", name), "EE-221", what, found=name, expected="another name"
            )


def _claims(stanzas: list[Keys], *keys: str) -> tuple[Keys, ...]:
    return tuple((*stanza, key) for stanza in stanzas for key in keys)


def _second(facts: Facts, what: str, claims: tuple[Keys, ...]) -> Iterator[Fault]:
    owners: dict[object, Keys] = {}
    for path in sorted(claims, key=lambda each: facts.places.value(*each).order):
        value = facts.get(*path) or _ros_default(facts, path)
        if value is None or (value == NO_CHANNEL and what in ("channel", "bit")):
            continue
        if value not in owners:
            owners[value] = path
            continue
        owner = owners[value]
        device = owner[1] if owner[0] in ("actuators", "channels", "outputs") else owner[0]
        written = f"{path[-1]}: {value}" + ("" if facts.written(*path) else " (default)")
        place, sentence = facts.places.value(*path), f"{what} {value!r} already belongs to {str(device)!r}"
        yield Fault.at(place, "EE-221", sentence, found=written, expected=f"a {what} of its own")


def _ros_default(facts: Facts, path: Keys) -> str | None:
    if path[0] != "actuators" or path[-1] not in ROS or path in facts.broken:
        return None
    return ROS[str(path[-1])] + camel_case(str(path[1]))
