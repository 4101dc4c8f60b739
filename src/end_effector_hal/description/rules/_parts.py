"""Rules of the parts that a tool grips, and the tool as it grips each of them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from end_effector_hal.description._fault import Fault, did_you_mean
from end_effector_hal.description._shape import Facts
from end_effector_hal.description.model._description import Description, with_keys
from end_effector_hal.description.model._stanzas import OF_THE_COMMAND, SAME_FOR_ALL_PARTS


def part_faults(facts: Facts) -> Iterator[Fault]:
    """Yield a fault for each part that names another actuator, or changes what is the same for all parts."""
    sequence, used = facts.names("sequence"), set[str]()
    parts, read = _parts(facts), ("sequence",) not in facts.broken and bool(sequence)
    for name, stanza in parts.items() if read else ():
        own = stanza.get("uses")
        uses = [str(each) for each in own] if isinstance(own, list) else sequence
        used |= set(uses)
        for index, each in enumerate(uses if isinstance(own, list) else ()):
            place = facts.places.value("parts", name, "uses", index)
            if each not in sequence:
                expected, hint = f"one of {', '.join(sequence)}", did_you_mean(each, sequence)
                yield Fault.at(
                    place, "EE-220", "uses names no actuator of the sequence", expected=expected, hint=hint
                )
            elif each in uses[:index]:
                yield Fault.at(place, "EE-220", f"actuator {each!r} is repeated in uses", expected="it once")
        actuators = stanza.get("actuators")
        for each, keys in actuators.items() if isinstance(actuators, dict) else ():
            path = ("parts", name, "actuators", str(each))
            if each not in uses and set(uses) <= set(sequence):
                expected = f"one of {', '.join(uses)}"
                what = f"{each!r} does not grip {name}"
                yield facts.key_fault(path, "EE-220", what, expected, hint=did_you_mean(each, uses))
            elif isinstance(keys, dict):
                yield from _shared_keys(facts, path, keys)
    for each in sequence if parts and read else ():
        if each not in used and None not in [facts.unbroken("parts", name) for name in parts]:
            what = f"no part uses the actuator {each!r}"
            yield facts.fault(
                ("sequence", sequence.index(each)),
                "EE-220",
                what,
                "it in the uses of a part, or not in the sequence",
            )


def _shared_keys(facts: Facts, path: tuple[str, ...], keys: dict[str, Any]) -> Iterator[Fault]:
    inside, described = keys.get("modbus"), facts.get("actuators", path[-1], "modbus")
    bus = (
        [(*path, "modbus", key) for key in inside if key not in OF_THE_COMMAND]
        if isinstance(inside, dict)
        else []
    )
    for each in [*((*path, key) for key in keys if key in SAME_FOR_ALL_PARTS), *bus]:
        what = f"{each[-1]!r} is the same for all parts"
        yield facts.key_fault(each, "EE-205", what, f"it under actuators.{path[-1]}", found=str(each[-1]))
    bits = isinstance(described, dict) and (
        described.get("bitmask") or described.get("register_type") == "coil"
    )
    if bits and isinstance(inside, dict) and "command_on" in inside:
        what = "command_on of a coil or of a bitmask is the same for all parts"
        yield facts.fault((*path, "modbus", "command_on"), "EE-229", what, "no command_on here")


def activation_faults(description: Description, changed: Description) -> Iterator[Fault]:
    """Yield a fault for each part whose command has other activation bits than the actuator's."""
    for line, output in changed.register_outputs.items():
        if output.commands_activate != description.register_outputs[line].commands_activate:
            name = next(name for name, actuator in changed.ordered if actuator.line == line)
            what = "the activation bits of this command differ from those of the actuator's command"
            place = changed.place("actuators", name, "modbus", "command_on")
            yield Fault.at(place, "EE-229", what, expected="the same activation bits in both")


def whole_parts(facts: Facts) -> Iterator[Facts]:
    """Yield the description as it is for each part: with the part's values in the stanzas of the actuators."""
    actuators = facts.get("actuators")
    for name, stanza in _parts(facts).items() if isinstance(actuators, dict) else ():
        own = stanza.get("actuators")
        changed = {
            str(each): with_keys(actuators[each], keys)
            for each, keys in (own.items() if isinstance(own, dict) else ())
            if isinstance(keys, dict) and isinstance(actuators.get(each), dict)
        }
        if changed:
            tree = {key: value for key, value in facts.tree.items() if key != "parts"}
            yield Facts({**tree, "actuators": {**actuators, **changed}}, facts.places.for_part(name))


def _parts(facts: Facts) -> dict[str, dict[str, Any]]:
    """Return the stanza of each part that can be read."""
    parts = facts.get("parts")
    found = parts.items() if isinstance(parts, dict) else ()
    return {str(name): stanza for name, stanza in found if isinstance(stanza, dict)}
