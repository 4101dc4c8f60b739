"""Map a status of the tool to the levels of its lines, and to the last will that fits them."""

from __future__ import annotations

from collections.abc import Mapping

from end_effector_hal.control import GripLastWill, Status, changer_will, maintenance_will
from end_effector_hal.description import Description
from end_effector_hal.vocabulary import NO_PART, EndEffectorState, LastWill, WrittenPart

from ._maintenance import Maintenance


class OutputMapping:
    """Maps statuses to the lines of the tool; maintenance drives lines of actuators too, unknown to the automata."""

    def __init__(self, description: Description, maintenance: Maintenance) -> None:
        self._description, self._maintenance = description, maintenance
        self._grip_will = GripLastWill(description)
        self._lines = [actuator.line for _, actuator in description.ordered]
        place = description.sequence.index
        self._blow_offs = [(each.line, place(name)) for name, each in description.blow_offs.items()]
        chosen = description.part_outputs
        self._values = {
            name: {
                actuator.line: actuator.modbus.command_on
                for _, actuator in tool.ordered
                if actuator.modbus and actuator.line in chosen
            }
            for name, tool in zip(description.part_names, description.per_part, strict=True)
        }
        changer = description.tool_changer
        self.unlock_line = changer.line if changer else ""
        """The line that unlocks the tool changer; empty: the tool has none."""

    @property
    def maintenance_lines(self) -> tuple[str, ...]:
        """The lines that maintenance drives now."""
        return tuple(self._maintenance.lines)

    def levels(self, status: Status) -> dict[str, bool]:
        """Return the level that a status requests for every output, by line."""
        levels = dict(zip(self._lines, status.outputs, strict=True))
        for line, index in self._blow_offs:
            levels[line] = index in status.blowing
        if self.unlock_line:
            levels[self.unlock_line] = status.unlock_output
        return levels

    def grips(self, status: Status, changes: Mapping[str, bool]) -> WrittenPart:
        """Return the part of a status, and the registers that grip it of the outputs that are activated."""
        if not status.part:
            return NO_PART
        chosen = self._values.get(status.part, {})
        return WrittenPart(
            status.part, {line: chosen[line] for line, on in changes.items() if on and line in chosen}
        )

    def dropped(self, status: Status) -> str:
        """Return the line that a Drop has deactivated last, until the Drop is over; empty: none."""
        return self._lines[status.dropped] if status.dropped >= 0 else ""

    def last_will(self, status: Status, on: str = "process_death") -> LastWill:
        """Return the steps that the line arbiter executes at an ending; ``on`` is its name in the description.

        While maintenance drives lines, they replace what the gripping would do; the tool changer locks in any case.
        """
        lines = self._maintenance.lines
        gripping = maintenance_will(lines) if lines else self._grip_will.of(status, on=on)
        if not status.unlock_output:
            return gripping
        return (*changer_will(self._description, status, on=on), *gripping)

    def maintenance_will(self, status: Status, line: str, *, active: bool) -> LastWill:
        """Return the last will that applies once maintenance has driven ``line`` to ``active``."""
        return (*changer_will(self._description, status), *self._maintenance.will_with(line, active))

    def gripping(self, status: Status) -> bool:
        """Return whether a grip is running, with activations still to come."""
        return status.ee == EndEffectorState.GRIPPING
