"""What judges a run in virtual time, whatever disturbed it: the monitor of each program, and what is really gripped."""

from __future__ import annotations

from collections.abc import Callable

from end_effector_hal.control import network_of
from end_effector_hal.description import Description
from end_effector_hal.vocabulary import Command, EndEffectorState
from end_effector_lab.virtual import VirtualTool
from timed_automata.execute import Observation
from timed_automata.monitor import Monitor

from ._script import STAND_BY

AT_REST = (STAND_BY, EndEffectorState.GRIPPED, EndEffectorState.GRIP_ERROR, EndEffectorState.RELEASE_ERROR)


class Monitors:
    """One for each controller that begins, with the requirements of the automata."""

    def __init__(self, description: Description) -> None:
        self._automata, self._network = description.automata, network_of(description)
        self._monitors: list[Monitor] = []

    def watch(self, program: str) -> Callable[[Observation], None]:
        """A `Watch` of a `VirtualTool`."""
        executed, interface = getattr(self._automata, program), self._automata.interface
        monitor = Monitor(self._network, executed, interface, requirements=True)
        self._monitors.append(monitor)
        return monitor.observe

    @property
    def objections(self) -> list[str]:
        """What all of them have said, sentences."""
        return [each.what for monitor in self._monitors for each in monitor.objections]


def is_still(description: Description, tool: VirtualTool) -> bool:
    """Whether all processes run, no command does, and nothing is to come of the unlock output."""
    status, changer = tool.status, description.tool_changer
    unlocked = bool(changer and tool.levels.get(changer.line))
    return len(tool.living) == 3 and status.ee in AT_REST and status.command == Command.NONE and not unlocked


def not_gripping(description: Description, tool: VirtualTool) -> list[str]:
    """Actuators that do not grip, as the simulated devices really are."""
    return [name for name in description.sequence if not tool.bench.devices[name].grips]
