"""Texts that explain decisions of the automata. This module makes no decisions."""

from __future__ import annotations

from end_effector_hal.control._status import Status
from end_effector_hal.description import Description
from end_effector_hal.kinds import confirmed_words, kind_of, lost_words, present_words
from end_effector_hal.sensing import SensorState
from end_effector_hal.vocabulary import Cause, EndEffectorState, Evidence, display_name, printable

from ._changer_reasons import changer_refusal, feedback, loose, unlock_blocking


def explain(description: Description, cause: int, cause_at: int, senses: SensorState, at: int) -> str:
    """Return why a grip or a release ended at ``at`` µs; empty: there is no cause."""
    name, actuator = description.ordered[cause_at] if cause_at >= 0 else ("", None)
    who = display_name(name) or "The grip"
    if cause == Cause.TIMED_OUT and actuator:
        empty = f" {said}." if (said := senses.empty(cause_at)) else ""
        return (
            f"{who} was not confirmed within {actuator.timeout_s:g} s in {actuator.attempts} attempts.{empty}"
        )
    if cause == Cause.EMPTY and actuator:
        tried = f"all {actuator.attempts} attempts have" if actuator.attempts > 1 else "its only attempt has"
        return f"{who} {kind_of(actuator).empty}: {tried} failed."
    if cause == Cause.LOST and actuator:
        return f"{who} was lost: {lost_words(actuator, senses.readings, at)}."
    if cause == Cause.REFUSED:
        return f"The line arbiter refused to activate {display_name(name) or 'an output'}."
    return {
        Cause.NONE: "",
        Cause.LOST: f"{who} was lost.",
        Cause.CANCELLED: "The grip was cancelled.",
        Cause.STILL_PRESENT: f"Everything is deactivated, but {_present(description, senses, at)}",
        Cause.NOT_PROVEN: "Everything is deactivated, but a reading is not valid: it is not proven that all is gone. "
        + _present(description, senses, at),
        Cause.UNPROVEN_AT_START: "Outputs were active at the start and the sensors do not confirm a grip.",
        Cause.RELEASED_AT_START: "Outputs were active at the start; they are deactivated, as declared.",
    }.get(Cause(cause), "")


def left_active(description: Description, outputs: tuple[bool, ...]) -> str:
    """Return a sentence with the actuators that an unwinding has left active."""
    names = [display_name(name) for name, active in zip(description.sequence, outputs, strict=True) if active]
    return f"{', '.join(names)} stay{'s' if len(names) == 1 else ''} active, as declared."


def held_words(state: EndEffectorState) -> str:
    """Return a clause about the held part: only in GRIPPED the sensors prove it, else it is possible."""
    return "a part is held" if state is EndEffectorState.GRIPPED else "a part is held, or may be"


def no_part(description: Description, name: str) -> str:
    """Return that there is no such part, and what there is."""
    known = ", ".join(description.parts)
    there = f"there are: {known}." if known else "the description has no `parts`."
    return f"There is no part {printable(name)!r}; {there}"


def no_maintenance(state: EndEffectorState, *, held: bool) -> str:
    """Return why maintenance cannot drive outputs in this state; empty: it can."""
    if held:
        return f"IL-12: {held_words(state)} ({_name(state)}): no maintenance, only a Drop releases it."
    if state is EndEffectorState.STAND_BY:
        return ""
    return f"IL-12: maintenance is possible in STAND_BY only; the end-effector is {_name(state)}."


def _present(description: Description, senses: SensorState, at: int) -> str:
    """Return why it is not proven that nothing is gripped, with the readings of the first such actuator."""
    pairs = zip(description.ordered, senses.evidence, strict=True)
    left = [(name, actuator, level) for (name, actuator), level in pairs if level is not Evidence.GONE]
    if not left:
        return "a sensor still shows feedback."
    if owed := [display_name(description.sequence[index]) for index in senses.withheld]:
        return (
            f"the device of {', '.join(owed)} has not acknowledged it: it may activate the output later. "
            "Check the bus and the device."
        )
    names = ", ".join(display_name(name) for name, _, _ in left)
    known = any(level is not Evidence.UNKNOWN for _, _, level in left)
    shows = f" still show{'' if len(left) > 1 else 's'} feedback" if known else ""
    actuator = left[0][1]
    said = f"{names}{shows}: {present_words(actuator, description.supply, senses.readings, at)}"
    activation = actuator.modbus.activation if actuator.modbus else None
    ready = senses.readings.get(activation.ready, at) if activation else None
    if activation is None or ready is None or ready:
        return said
    limit = f"{activation.ready_within_s:g} s"
    return (
        f"{said} Its device is not activated ({activation.ready} is off); that may take {limit} after a Drop."
    )


def refusal(
    description: Description,
    command: str,
    status: Status,
    senses: SensorState,
    at: int,
    *,
    fault: bool = False,
) -> str:
    """Return why a command is not accepted now; ``fault``: the tool changer is in FAULT."""
    state = status.ee
    if command == "grip":
        if state is not EndEffectorState.STAND_BY:
            return f"A grip is accepted in STAND_BY only; the end-effector is {_name(state)}."
        found = blocking(description, status, senses, at, fault=fault)
        return found["IL-07"] or found["IL-05"] or found["IL-06"] or "The grip is not accepted now."
    if command == "drop":
        if state is EndEffectorState.RELEASING:
            return "A release is running already."
        return (
            "Nothing is held: a drop is accepted in GRIPPED, GRIP_ERROR and RELEASE_ERROR, and in STAND_BY while "
            f"something is not proven to be gone; this is {_name(state)}."
        )
    if command == "cancel":
        return f"There is no running grip to cancel; the end-effector is {_name(state)}."
    if command == "resume":
        return _resume_refusal(description, status, senses, at, fault=fault)
    if command in ("lock", "unlock", "arm", "reset"):
        return changer_refusal(description, command, status, senses)
    return f"{command!r} is not accepted now; the end-effector is {_name(state)}."


def _resume_refusal(
    description: Description, status: Status, senses: SensorState, at: int, *, fault: bool
) -> str:
    if status.ee is not EndEffectorState.GRIP_ERROR:
        return f"Nothing was lost: a resume is accepted in GRIP_ERROR only; the end-effector is {_name(status.ee)}."
    active = all(level or not used for level, used in zip(status.outputs, senses.used, strict=True))
    if status.cause is not Cause.LOST or not active:
        return f"A resume is accepted only after a loss that left every output active. {status.reason} Drop first."
    for (name, actuator), level, used in zip(description.ordered, senses.evidence, senses.used, strict=True):
        if used and level is not Evidence.CONFIRMED:
            shows = confirmed_words(actuator, description.supply, senses.readings, at)
            return f"{display_name(name)} is not confirmed again: {shows}."
    if why := loose(description, senses, unlocking=status.unlock_output, fault=fault):
        return f"IL-05: {why}."
    return "The part was never gripped completely. Drop first."


def blocking(
    description: Description, status: Status, senses: SensorState, at: int, *, fault: bool = False
) -> dict[str, str]:
    """Return the reason of each interlock against a grip or an unlock now, a sentence; empty: none.

    Only interlocks of the programs that a description can switch off are included; the line arbiter has its own.
    """
    locks, said = description.interlocks, dict.fromkeys(("IL-01", "IL-02", "IL-05", "IL-06", "IL-07"), "")
    if locks.il_07 and (down := senses.readings.down(at)):
        said["IL-07"] = f"IL-07: the {description.sensors_are('not up', down[0].link)}."
    elif locks.il_07 and (present := feedback(description, senses, at)):
        said["IL-07"] = f"IL-07: {present}"
    if (changer := description.tool_changer) is not None:
        if why := loose(description, senses, unlocking=status.unlock_output, fault=fault):
            said["IL-05"] = f"IL-05: {why}."
        said |= unlock_blocking(description, changer, status, senses)
    if locks.il_06 and not senses.supply.ok:
        said["IL-06"] = f"IL-06: {_no_air(description, senses)}"
    return said


def _no_air(description: Description, senses: SensorState) -> str:
    supply, kpa = description.supply, senses.supply.kpa
    if kpa is None:
        return "the supply pressure has no valid reading, or its switch shows no air."
    if kpa < supply.refuse_kpa:
        return f"the supply pressure is {kpa:.0f} kPa, a grip requires at least {supply.refuse_kpa:g} kPa."
    again_kpa = supply.refuse_kpa + supply.hysteresis_kpa
    return f"the supply pressure was too low and is {kpa:.0f} kPa, a grip requires at least {again_kpa:g} kPa again."


def _name(state: EndEffectorState) -> str:
    return "OFF (not adopted yet)" if state is EndEffectorState.OFF else state.name
