"""Map a status of a program to the levels of its lines, and to the last will that fits them."""

from __future__ import annotations

from typing import Protocol

from end_effector_hal.control import GripLastWill, Status, changer_will
from end_effector_hal.description import Description
from end_effector_hal.vocabulary import EndEffectorState, LastWill

from ._maintenance import Maintenance


class OutputMapping(Protocol):
    """Maps the statuses of one program to its lines."""

    def adopted(self, status: Status) -> bool:
        """Return whether the automata have adopted the lines; before that nothing is written."""

    def levels(self, status: Status) -> dict[str, bool]:
        """Return the level that a status requests for every output, by line."""

    def dropped(self, status: Status) -> str:
        """Return the line that a Drop has deactivated last, until the Drop is over; empty: none."""

    def last_will(self, status: Status, on: str = "process_death") -> LastWill:
        """Return the steps that the line arbiter executes at an ending; ``on`` is its name in the description."""

    def gripping(self, status: Status) -> bool:
        """Return whether a grip is running, with activations still to come."""


class GripOutputs:
    """Maps statuses to the lines of the actuators; maintenance drives these lines too, unknown to the automata."""

    def __init__(self, description: Description, maintenance: Maintenance) -> None:
        self._maintenance, self._last_will = maintenance, GripLastWill(description)
        self._lines = [part.line for _, part in description.ordered]
        place = description.sequence.index
        self._blow_offs = [(each.line, place(name)) for name, each in description.blow_offs.items()]

    def adopted(self, status: Status) -> bool:
        """Return whether the automata have adopted the lines."""
        return status.ee != EndEffectorState.OFF

    def levels(self, status: Status) -> dict[str, bool]:
        """Return the level of the line of every actuator, and of the blow-off valves that a release drives."""
        blowing = {line: index in status.blowing for line, index in self._blow_offs}
        return dict(zip(self._lines, status.outputs, strict=True)) | blowing

    def dropped(self, status: Status) -> str:
        """Return the line of the actuator that a Drop has deactivated last."""
        return self._lines[status.dropped] if status.dropped >= 0 else ""

    def last_will(self, status: Status, on: str = "process_death") -> LastWill:
        """Return the steps that the line arbiter executes at an ending."""
        return self._maintenance.will or self._last_will.of(status, on=on)

    def gripping(self, status: Status) -> bool:
        """Return whether a grip is running."""
        return status.ee == EndEffectorState.GRIPPING


class ChangerOutputs:
    """Maps statuses to the unlock output of the tool changer."""

    def __init__(self, description: Description) -> None:
        self._description = description

    def adopted(self, status: Status) -> bool:
        """Return whether the automata have adopted the line; a tool without a changer has none, and writes nothing."""
        return status.adopted and self._description.tool_changer is not None

    def levels(self, status: Status) -> dict[str, bool]:
        """Return the level of the unlock line, if the tool has a changer."""
        changer = self._description.tool_changer
        return {changer.line: status.unlock_output} if changer else {}

    def dropped(self, status: Status) -> str:
        """Return an empty string: a Drop concerns no line of the tool changer."""
        del status
        return ""

    def last_will(self, status: Status, on: str = "process_death") -> LastWill:
        """Return the steps that the line arbiter executes at an ending."""
        return changer_will(self._description, status, on=on)

    def gripping(self, status: Status) -> bool:
        """Return False: this program runs no grip."""
        del status
        return False
