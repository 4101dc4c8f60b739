"""Pass the observations of every controller to a monitor while the program runs."""

from __future__ import annotations

from collections.abc import Callable

from end_effector_hal.control import Controller, network_of
from end_effector_hal.description import Description
from end_effector_hal.runtime.boundary import Recorder
from timed_automata import Network
from timed_automata.execute import Observation
from timed_automata.monitor import Monitor

Watch = Callable[[], Callable[[Observation], None]]
"""Called for each new controller; returns a receiver of its observations."""


class Watching(Recorder):
    """A recorder that stores nothing, and passes the observations of every controller to a `Watch`."""

    def __init__(self, watch: Watch) -> None:
        super().__init__()
        self._watch = watch

    def controller(self, description: Description, network: Network) -> Controller:
        """Return a controller that is observed from its start."""
        return Controller(description, network, observe=self._watch())


class Monitors:
    """Creates a monitor for each new controller, with the requirements of the automata."""

    def __init__(self, description: Description) -> None:
        self._automata, self._network = description.automata, network_of(description)
        self._monitors: list[Monitor] = []

    def watch(self) -> Callable[[Observation], None]:
        """Create a monitor for a controller; return the function that receives its observations."""
        automata = self._automata
        monitor = Monitor(self._network, automata.executed, automata.interface, requirements=True)
        self._monitors.append(monitor)
        return monitor.observe

    @property
    def objections(self) -> list[str]:
        """The objections of all monitors, as sentences."""
        return [each.what for monitor in self._monitors for each in monitor.objections]
