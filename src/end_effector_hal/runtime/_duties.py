"""What a program owes its lines: their levels, the will for its death, and what it leaves at its end."""

from __future__ import annotations

from dataclasses import replace

from end_effector_hal.control import Status, will_of
from end_effector_hal.description import Description
from end_effector_hal.vocabulary import EndEffectorState, LastWillStep

from ._maintenance import Maintenance

LastWill = tuple[LastWillStep, ...]


class Duties:
    """Of ``grip`` or ``tool_change``, with what is driven by hand, of which the automata know nothing."""

    def __init__(self, description: Description, program: str, maintenance: Maintenance) -> None:
        self._description, self._maintenance = description, maintenance
        self._changes = program == "tool_change"

    def levels(self, status: Status) -> dict[str, bool]:
        """Line and level of every output that a status asks for."""
        if self._changes:
            changer = self._description.tool_changer
            return {changer.line: status.unlock_output} if changer else {}
        return {
            actuator.line: output
            for (_, actuator), output in zip(self._description.ordered, status.outputs, strict=True)
        }

    def will(self, status: Status, on: str = "process_death") -> LastWill:
        """What the line arbiter does at an ending, by its name in the description."""
        if self._changes:
            changer = self._description.tool_changer
            if not (changer and status.unlock_output and getattr(changer.endings, on) == "release"):
                return ()
            return (LastWillStep(changer.line),)  # an inactive line is locked
        return self._maintenance.will or will_of(self._description, status, on=on)

    def grips(self, status: Status) -> bool:
        """Whether a grip is at work here, with activations to come."""
        return not self._changes and status.ee == EndEffectorState.GRIPPING

    def seen(self, status: Status) -> Status:
        """A status with what is active by hand."""
        if not self._maintenance.active:
            return status
        lines = self._maintenance.lines
        parts = zip(self._description.ordered, status.outputs, strict=True)
        outputs = tuple(output or part.line in lines for (_, part), output in parts)
        return replace(status, outputs=outputs, deadline=self._maintenance.ends_at, maintenance=True)
