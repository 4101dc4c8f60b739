"""Texts that explain decisions about the tool changer. This module makes no decisions."""

from __future__ import annotations

from end_effector_hal.control._status import Status
from end_effector_hal.description import Description, ToolChanger
from end_effector_hal.kinds import kind_of, present_words
from end_effector_hal.sensing import SensorState
from end_effector_hal.vocabulary import (
    ChangerFault,
    ChangerState,
    EndEffectorState,
    Evidence,
    ToolEvidence,
    display_name,
)

_REST = (EndEffectorState.STAND_BY, EndEffectorState.OFF)


def explain_changer(description: Description, fault: int) -> str:
    """Return why the tool changer is in FAULT, and the remedy; empty: it is not."""
    changer = description.tool_changer
    if changer is None or fault == ChangerFault.NONE:
        return ""
    if fault == ChangerFault.SENSOR:
        return (
            f"IL-04: {changer.locked_bit} and {changer.unlocked_bit} were both on, or both off, for "
            f"{changer.fault_s:g} s: a sensor fault, until a reset."
        )
    return "The tool changer is not where it should be, as its sensors have it: lock it again, or reset."


def loose(description: Description, senses: SensorState, *, unlocking: bool, fault: bool) -> str:
    """Return a clause why the tool is not proven to be locked (IL-05); empty: no fitted sensor objects.

    Args:
        description: the tool.
        senses: the evidence of the sensors.
        unlocking: whether the unlock output is active.
        fault: whether the tool changer is in FAULT.
    """
    changer = description.tool_changer
    if changer is None or not description.interlocks.il_05:
        return ""
    if senses.tool is ToolEvidence.ABSENT:
        return f"there is no tool ({changer.present_bit} is off)"
    fitted = {changer.locked_bit, changer.unlocked_bit} <= senses.readings.carried.keys()
    if fitted and senses.tool is not ToolEvidence.LOCKED:
        return f"the tool is not proven to be locked (its sensors say {senses.tool.name})"
    if unlocking:
        return "the unlock output is active"
    return "the tool changer is in FAULT" if fitted and fault else ""


def feedback(description: Description, senses: SensorState, at: int) -> str:
    """Return why it is not proven at ``at`` µs that nothing is gripped, and the remedy; empty: it is."""
    for (name, actuator), level in zip(description.ordered, senses.evidence, strict=True):
        if level is Evidence.GONE:
            continue
        what = {
            Evidence.UNKNOWN: "is not proven to be gone",
            Evidence.CONFIRMED: "shows feedback although it is not active",
        }.get(level, "is not active, but its feedback is not proven to be gone")
        todo = "Check its sensor." if level is Evidence.UNKNOWN else "A Drop releases it once more."
        shows = present_words(actuator, description.supply, senses.readings, at)
        return f"{display_name(name)} {what}: {shows} {todo}"
    return ""


def changer_refusal(description: Description, command: str, status: Status, senses: SensorState) -> str:
    """Return why ``lock``, ``unlock``, ``arm`` or ``reset`` is not accepted now."""
    changer, state = description.tool_changer, status.changer
    if changer is None:
        return "The tool has no tool changer."
    if command == "lock" and senses.tool is ToolEvidence.ABSENT:
        return f"A lock is refused: there is no tool ({changer.present_bit} is off)."
    if state is ChangerState.FAULT:
        if command == "reset":
            return (
                f"The sensors of the tool changer still contradict each other. {_fault(description, status)}"
            )
        return f"The tool changer is FAULT. {_fault(description, status)}"
    if command == "unlock":
        return _unlock_refusal(description, changer, status, senses)
    if command == "arm":
        return _arm_refusal(description, changer, state, senses)
    if command == "reset":
        return f"Nothing is latched: the tool changer is {state.name}."
    return f"A lock is not accepted now; the tool changer is {state.name}."


def _vacant(state: ChangerState, senses: SensorState) -> bool:
    return state is ChangerState.UNKNOWN and senses.tool is ToolEvidence.ABSENT


def _fault(description: Description, status: Status) -> str:
    return explain_changer(description, status.changer_fault)


def _unlock_refusal(
    description: Description, changer: ToolChanger, status: Status, senses: SensorState
) -> str:
    if status.changer is not ChangerState.LOCKED and not _vacant(status.changer, senses):
        return f"An unlock is accepted when the tool changer is LOCKED; it is {status.changer.name}."
    found = unlock_blocking(description, changer, status, senses)
    return found["IL-01"] or found["IL-02"] or "An unlock is not accepted now."


def unlock_blocking(
    description: Description, changer: ToolChanger, status: Status, senses: SensorState
) -> dict[str, str]:
    """Return the reasons of IL-01 and IL-02 against an unlock now, a sentence each; empty: none."""
    locks, at_rest, said = description.interlocks, status.ee, {"IL-01": "", "IL-02": ""}
    if locks.il_01 and at_rest not in _REST:
        said["IL-01"] = f"IL-01: unlock only in STAND_BY; the end-effector is {at_rest.name}."
    elif locks.il_01 and not senses.nothing_gripped:
        said["IL-01"] = f"IL-01: {_not_released(description, changer, senses, status.at)}"
    if locks.il_02 and not senses.in_stand:
        bit = changer.stand_bit
        if bit in senses.readings.carried:
            said["IL-02"] = (
                f"IL-02: the tool is not in its stand ({bit} is off or has no valid reading), nor absent."
            )
        elif not status.armed:
            said["IL-02"] = (
                f"IL-02: no sensor shows where the tool is: arm first, then unlock within {changer.arm_s:g} s."
            )
    return said


def _not_released(description: Description, changer: ToolChanger, senses: SensorState, at: int) -> str:
    if present := feedback(description, senses, at):
        return present
    below = [display_name(name) for name, actuator in description.ordered if kind_of(actuator).below_ambient]
    limit = f"under {changer.vented_kpa:g} kPa for {changer.vented_s:g} s"
    return f"{', '.join(below) or 'a vacuum'}: not proven to be {limit} yet."


def _arm_refusal(
    description: Description, changer: ToolChanger, state: ChangerState, senses: SensorState
) -> str:
    if not description.interlocks.il_02:
        return "IL-02 is switched off in the description: an unlock needs no arming."
    if changer.stand_bit in senses.readings.carried:
        return f"A sensor ({changer.stand_bit}) shows where the tool is: an unlock needs no arming."
    if state is not ChangerState.LOCKED and not _vacant(state, senses):
        return f"An unlock is armed when the tool changer is LOCKED; it is {state.name}."
    return f"An unlock cannot be armed now; the tool changer is {state.name}."
