"""Last wills: what the line owner does when a program dies, computed here, so that it knows no gripping logic."""

from __future__ import annotations

from collections.abc import Iterable

from end_effector_hal.description import Description
from end_effector_hal.vocabulary import EndEffectorState, LastWill, LastWillStep, to_us

from ._status import Status


def grip_will(description: Description, status: Status, *, on: str = "process_death") -> LastWill:
    """Deactivations in release order of what is engaged now and is declared to be released; empty: hold.

    Held, or left active by an unwinding: it stays, unless the description says otherwise (IL-09). Before GRIPPED:
    as it says; while releasing: the release is carried out. The owner sees no sensors, so it gives each step the whole
    time that the release allows it.

    Args:
        description: the tool.
        status: its state when the will is written.
        on: ``process_death`` or ``sigterm``, the ending that it is for.
    """
    if True not in status.outputs:
        return ()
    steps: list[LastWillStep] = []
    after_us = 0
    for name in description.releasing:
        index = description.sequence.index(name)
        if status.outputs[index] and not _stays(description, status, name, on, left=index in status.kept):
            actuator = description.actuators[name]
            steps.append(LastWillStep(actuator.line, after_us=after_us))
            after_us += to_us(actuator.release_s)
    return tuple(steps)


def changer_will(description: Description, status: Status, *, on: str = "process_death") -> LastWill:
    """The unlock output is deactivated where that is declared for an ending: an inactive line is locked."""
    changer = description.tool_changer
    if not (changer and status.unlock_output and getattr(changer.endings, on) == "release"):
        return ()
    return (LastWillStep(changer.line),)


def maintenance_will(lines: Iterable[str]) -> LastWill:
    """Everything that maintenance has activated is deactivated at once, however the program ends; in this order."""
    return tuple(LastWillStep(line) for line in lines)


def _stays(description: Description, status: Status, name: str, on: str, *, left: bool) -> bool:
    endings = description.endings_of(name)
    if status.held or left:
        return bool(getattr(endings.held, on) != "release")
    return status.ee != EndEffectorState.RELEASING and bool(getattr(endings.gripping, on) != "release")
