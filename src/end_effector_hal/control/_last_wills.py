"""Last wills: what the line arbiter does when a program dies, computed here, so that it knows no gripping logic."""

from __future__ import annotations

from collections.abc import Iterable

from end_effector_hal.description import Description
from end_effector_hal.vocabulary import EndEffectorState, LastWill, LastWillStep, display_name, to_us

from ._status import Status
from .words import left_active


class GripLastWill:
    """The end of a blow-off, then deactivations in release order of what is engaged and is declared to be released.

    Empty: hold. What is blown off is not held by its suction, so nothing falls for that end; no last will begins one.

    Held, or left active by an unwinding: it stays, unless the description says otherwise (IL-09). Before GRIPPED:
    as it says; while releasing: the release is carried out. The arbiter sees no sensors, so it gives each step the
    whole time that the release allows it.
    """

    def __init__(self, description: Description) -> None:
        actuators, place = description.actuators, description.sequence.index
        self._blow_offs = {place(name): each.line for name, each in description.blow_offs.items()}
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
        steps = [LastWillStep(self._blow_offs[index]) for index in status.blowing]
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


def ending_in_words(description: Description, status: Status, *, on: str) -> str:
    """What becomes of the outputs of a tool when its process ends like this, sentences; empty: nothing is active."""
    name_of = {part.line: name for name, part in description.ordered}
    will = GripLastWill(description).of(status, on=on)
    released = [name_of[step.line] for step in will if step.line in name_of]
    stay = tuple(
        active and name not in released
        for name, active in zip(description.sequence, status.outputs, strict=True)
    )
    said = [left_active(description, stay)] if any(stay) else []
    if released:
        order = ", then ".join(display_name(name) for name in released)
        said.insert(0, f"The line arbiter deactivates {order}, as declared.")
    if changer_will(description, status, on=on):
        said.append("The unlock output is deactivated, as declared.")
    return " ".join(said)
