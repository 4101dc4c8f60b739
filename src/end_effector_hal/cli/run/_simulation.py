"""A tool without hardware: the development tools have it, which a robot does not need; found by an entry point."""

from __future__ import annotations

import signal
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Protocol, cast

from end_effector_hal._extras import command_for
from end_effector_hal.errors import MissingExtraError, UsageError
from end_effector_hal.plugins import Plugins

if TYPE_CHECKING:
    from end_effector_hal.description import Description

GROUP = "end_effector_hal.simulation"
NAME = "lab"


class SimulatedHardware(Protocol):
    """Virtual lines, the testbench at their other end, and the line arbiter, which run."""

    description: Description
    """The tool on these lines."""

    def choose(self, bench: str, /) -> None:
        """Have another scenario at the testbench; raises UsageError, and nothing has changed."""
        ...


class Simulation(Protocol):
    """What the entry point names: starts it on entering, ends every process of it on leaving."""

    def __call__(
        self, description: Description, bench: str, folder: Path, *, outlives_us: bool, seed: int
    ) -> AbstractContextManager[SimulatedHardware]:
        """Args: the tool, a scenario of the testbench, a folder for the logs, whether the arbiter survives a kill,
            the seed of noise and dead times.

        Raises:
            UsageError: the tool cannot have this scenario.
        """
        ...

    def scenarios(self, description: Description, /) -> Iterable[str]:
        """What can go wrong with the tool, without numbers."""
        ...


def _checked(found: Any) -> Simulation:
    if not callable(found):
        raise UsageError("it is not callable.")
    return cast(Simulation, found)


_SIMULATION: Plugins[Simulation] = Plugins(GROUP, "simulation", {}, _checked, make=False)


def possible_scenarios(description: Description) -> Iterable[str]:
    """What can go wrong with the simulated tool; nothing where nothing that simulates is installed."""
    return _SIMULATION.get(NAME).scenarios(description) if NAME in _SIMULATION.names else ()


@contextmanager
def simulated(description: Description, scenario: str, seed: int = 0) -> Iterator[SimulatedHardware]:
    """The same tool on virtual lines, which run until it is left; nothing of them stays, no process and no file.

    Raises:
        MissingExtraError: nothing that simulates is installed.
        UsageError: the tool cannot have this scenario.
        ReportedError: a process of it does not start.
    """
    if NAME not in _SIMULATION.names:
        raise MissingExtraError(
            "The package that simulates a tool is not installed.", todo=f"Install it: {command_for('lab')}."
        )
    start = _SIMULATION.get(NAME)
    with TemporaryDirectory(prefix="eehal-run-", ignore_cleanup_errors=True) as folder:
        hardware = start(description, scenario, Path(folder), outlives_us=False, seed=seed)
        try:
            with hardware as running:
                try:
                    yield running
                finally:
                    _finish_undisturbed()
        finally:
            _finish_undisturbed()


def _finish_undisturbed() -> None:
    """A second Ctrl-C does not interrupt the end, which takes a few seconds at most."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
