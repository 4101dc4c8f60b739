"""From a status of a program to its lines: their levels, and the last will that fits them."""

from __future__ import annotations

from typing import Protocol

from end_effector_hal.control import GripLastWill, Status, changer_will
from end_effector_hal.description import Description
from end_effector_hal.vocabulary import EndEffectorState, LastWill

from ._maintenance import Maintenance


class OutputMapping(Protocol):
    """The lines of one program."""

    def adopted(self, status: Status) -> bool:
        """Whether the automata know the lines: before that nothing is written."""

    def levels(self, status: Status) -> dict[str, bool]:
        """Line and level of every output that a status asks for."""

    def dropped(self, status: Status) -> str:
        """The line that a Drop has deactivated last, until it is over; empty: none."""

    def last_will(self, status: Status, on: str = "process_death") -> LastWill:
        """What the line arbiter does at an ending, by its name in the description."""

    def gripping(self, status: Status) -> bool:
        """Whether a grip is at work, with activations to come."""


class GripOutputs:
    """The lines of the actuators; maintenance drives them, too, and the automata know nothing of that."""

    def __init__(self, description: Description, maintenance: Maintenance) -> None:
        self._maintenance, self._last_will = maintenance, GripLastWill(description)
        self._lines = [part.line for _, part in description.ordered]
        place = description.sequence.index
        self._blow_offs = [(each.line, place(name)) for name, each in description.blow_offs.items()]

    def adopted(self, status: Status) -> bool:
        """Whether the automata know the lines."""
        return status.ee != EndEffectorState.OFF

    def levels(self, status: Status) -> dict[str, bool]:
        """Line and level of every actuator, and of the blow-off valves that a release drives."""
        blowing = {line: index in status.blowing for line, index in self._blow_offs}
        return dict(zip(self._lines, status.outputs, strict=True)) | blowing

    def dropped(self, status: Status) -> str:
        """The line of the actuator that a Drop has deactivated last."""
        return self._lines[status.dropped] if status.dropped >= 0 else ""

    def last_will(self, status: Status, on: str = "process_death") -> LastWill:
        """What the line arbiter does at an ending."""
        return self._maintenance.will or self._last_will.of(status, on=on)

    def gripping(self, status: Status) -> bool:
        """Whether a grip is at work."""
        return status.ee == EndEffectorState.GRIPPING


class ChangerOutputs:
    """The unlock output."""

    def __init__(self, description: Description) -> None:
        self._description = description

    def adopted(self, status: Status) -> bool:
        """Whether the automata know the line."""
        return bool(status.changer)

    def levels(self, status: Status) -> dict[str, bool]:
        """The level of the unlock line, if the tool has a changer."""
        changer = self._description.tool_changer
        return {changer.line: status.unlock_output} if changer else {}

    def dropped(self, status: Status) -> str:
        """None: nobody drops a tool."""
        del status
        return ""

    def last_will(self, status: Status, on: str = "process_death") -> LastWill:
        """What the line arbiter does at an ending."""
        return changer_will(self._description, status, on=on)

    def gripping(self, status: Status) -> bool:
        """No grip is at work here."""
        del status
        return False
