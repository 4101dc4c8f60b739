"""From the text of a scenario to a scenario."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from difflib import get_close_matches
from typing import Any

from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError

from ._faults import FAULTS, Fault, Number
from ._scenario import Effect, Scenario
from .physics import Device, ToolChanger, physics_of

TOOL_CHANGER = "tool_changer"


def device_physics(description: Description) -> dict[str, type[Device]]:
    """How each device behaves that a fault can concern: ``tool_changer``, then the actuators."""
    changer: dict[str, type[Device]] = {TOOL_CHANGER: ToolChanger} if description.tool_changer else {}
    return changer | {name: physics_of(actuator.kind) for name, actuator in description.ordered}


def parse_scenario(text: str, description: Description) -> Scenario:
    """A scenario from faults with commas between them, such as ``leak:top_vacuum,silent-after:5``.

    Raises:
        UsageError: an unknown fault or actuator, a number that is missing or out of range, a fault that the
            actuator cannot have, or two faults that contradict each other.
    """
    physics = device_physics(description)
    whole: dict[str, Any] = {}
    devices: dict[str, dict[str, Any]] = {}
    for part in (each.strip() for each in text.split(",")):
        fault, device, number = _read(part, physics)
        changed = devices.setdefault(device, {}) if device else whole
        for key, value in fault.changes(number).items():
            if changed.get(key, value) != value:
                raise UsageError(f"scenario {text!r}: {part!r} contradicts what stands before it.")
            changed[key] = value
    effects = {device: replace(Effect(), **changed) for device, changed in devices.items()}
    return replace(Scenario(text=text, effects=effects), **whole)


def _read(part: str, physics: Mapping[str, type[Device]]) -> tuple[Fault, str, float]:
    """Fault, device (empty: none) and number (NaN: none) of one part."""
    name, *values = part.split(":")
    fault = next((fault for fault in FAULTS if fault.name == name), None)
    if fault is None:
        raise UsageError(
            f"no fault is named {name!r}.", todo=_instead(name, [fault.name for fault in FAULTS])
        )
    device = ""
    if fault.on:
        device = values.pop(0) if values else ""
        if device not in physics:
            what = f"{part!r}: no actuator is named {device!r}." if device else f"{part!r} names no actuator."
            raise UsageError(what, todo=_instead(device, physics))
        if physics[device].traits.isdisjoint(fault.on):
            raise UsageError(f"{part!r}: {device} cannot have this fault.")
    number = _number(part, values, fault.number) if fault.number else math.nan
    if values:
        raise UsageError(f"{part!r} has too many parts.", todo=f"Expected: {fault.usage}.")
    return fault, device, number


def _number(part: str, values: list[str], number: Number) -> float:
    if not values and number.default is not None:
        return number.default
    try:
        value = float(values.pop(0))
    except (ValueError, IndexError):
        value = math.nan
    if not number.low <= value <= number.high or (number.whole and not value.is_integer()):
        kind = "a whole number" if number.whole else "a number"
        expected = f"Expected: {number.name}, {kind} from {number.low:g} to {number.high:g}."
        raise UsageError(f"{part!r} needs a number.", todo=expected)
    return value


def _instead(wrong: str, right: Iterable[str]) -> str:
    names = list(right)
    close = get_close_matches(wrong, names, n=1, cutoff=0.5)
    return f"Did you mean {close[0]!r}?" if close else f"There are: {', '.join(names)}."
