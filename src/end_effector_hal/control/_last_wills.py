"""Last wills: what the line arbiter does when a program dies, computed here, so that it knows no gripping logic."""

from __future__ import annotations

from collections.abc import Iterable

from end_effector_hal.description import Description
from end_effector_hal.vocabulary import EndEffectorState, LastWill, LastWillStep, to_us

from ._status import Status


class GripLastWill:
    """Deactivations in release order of what is engaged now and is declared to be released; empty: hold.

    Held, or left active by an unwinding: it stays, unless the description says otherwise (IL-09). Before GRIPPED:
    as it says; while releasing: the release is carried out. The owner sees no sensors, so it gives each step the whole
    time that the release allows it.
    """

    def __init__(self, description: Description) -> None:
        actuators, place = description.actuators, description.sequence.index
        self._parts = [
            (
                place(name),
                actuators[name].line,
                to_us(actuators[name].release_s),
                description.endings_of(name),
            )
            for name in description.releasing
        ]

    def of(self, status: Status, *, on: str = "process_death") -> LastWill:
        """The last will for a status, and for an ending: ``process_death`` or ``sigterm``."""
        steps: list[LastWillStep] = []
        after_us = 0
        releasing = status.ee == EndEffectorState.RELEASING
        for index, line, release_us, endings in self._parts:
            if not status.outputs[index]:
                continue
            if status.held or index in status.kept:
                released = getattr(endings.held, on) == "release"
            else:
                released = releasing or getattr(endings.gripping, on) == "release"
            if released:
                steps.append(LastWillStep(line, after_us=after_us))
                after_us += release_us
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
