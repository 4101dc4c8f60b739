"""Last wills: the deactivations that the line arbiter does if a program dies.

They are computed here, so that the line arbiter needs no gripping logic.
"""

from __future__ import annotations

from collections.abc import Iterable

from end_effector_hal.description import Description
from end_effector_hal.vocabulary import EndEffectorState, LastWill, LastWillStep, display_name, to_us

from ._status import Status
from .words import left_active


class GripLastWill:
    """Computes the last will of gripping: the end of a blow-off, then deactivations in release order.

    It deactivates active outputs that the description declares to be released; an empty will means hold. The end of a
    blow-off drops nothing, because a part that is blown off is no longer held by its suction; no last will begins a
    blow-off.

    An output of a held part, or one that an unwinding has left active, stays active unless the description declares
    otherwise (IL-09). Before GRIPPED the declared endings apply; while releasing, the release is completed. The line
    arbiter reads no sensors for this, so every step gets the full time that a release allows it.
    """

    def __init__(self, description: Description) -> None:
        actuators, place = description.actuators, description.sequence.index
        self._blow_offs = {place(name): each.line for name, each in description.blow_offs.items()}
        self._actuators = [
            (
                place(name),
                actuators[name].line,
                to_us(actuators[name].release_s),
                description.endings_of(name),
            )
            for name in description.releasing
        ]

    def of(self, status: Status, *, on: str = "process_death") -> LastWill:
        """Return the last will for a status and an ending, ``process_death`` or ``sigterm``."""
        steps = [LastWillStep(self._blow_offs[index]) for index in status.blowing] if status.blowing else []
        after_us = 0
        releasing = status.ee == EndEffectorState.RELEASING
        for index, line, release_us, endings in self._actuators:
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
    """Return the last will: it deactivates the unlock output, which locks, if declared for the ending."""
    changer = description.tool_changer
    if not (changer and status.unlock_output and getattr(changer.endings, on) == "release"):
        return ()
    return (LastWillStep(changer.line),)


def maintenance_will(lines: Iterable[str]) -> LastWill:
    """Return the last will that deactivates the lines driven by maintenance, at once and in this order.

    It applies to every way in which the program can end.
    """
    return tuple(LastWillStep(line) for line in lines)


def ending_in_words(description: Description, status: Status, *, on: str) -> str:
    """Return what happens to the outputs at this end of the tool's process; empty: none is active."""
    name_of = {actuator.line: name for name, actuator in description.ordered}
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
