"""Runs a tool without hardware by means of the development tools, which a robot does not need; an entry point names
them.
"""

from __future__ import annotations

import signal
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Protocol, cast

from end_effector_hal._extras import lab_installed, lab_needed
from end_effector_hal.plugins import Plugins, a_function

if TYPE_CHECKING:
    from end_effector_hal.description import Description

GROUP = "end_effector_hal.simulation"
NAME = "lab"


class SimulatedHardware(Protocol):
    """Running virtual lines, with the testbench at their other end and the line arbiter."""

    description: Description
    """The description of the tool on these lines."""

    def choose(self, bench: str, /) -> None:
        """Select another scenario at the testbench; raises UsageError if it is refused, and then nothing changes."""
        ...


class Simulation(Protocol):
    """The entry point's object: starts the simulated hardware on entering, and ends all its processes on leaving."""

    def __call__(
        self, description: Description, bench: str, folder: Path, *, outlives_us: bool, seed: int
    ) -> AbstractContextManager[SimulatedHardware]:
        """Return the simulated hardware as a context.

        Args:
            bench: a scenario of the testbench.
            folder: the folder for the logs.
            outlives_us: whether the arbiter survives a kill of this process.
            seed: the seed of noise and dead times.

        Raises:
            UsageError: the tool cannot have this scenario.
        """
        ...

    def scenarios(self, description: Description, /) -> Iterable[str]:
        """Return the possible scenarios of the tool, without numbers."""
        ...


_SIMULATION: Plugins[Simulation] = Plugins(
    GROUP, "simulation", {}, lambda found: cast(Simulation, a_function(found)), make=False
)


def possible_scenarios(description: Description) -> Iterable[str]:
    """Return the scenarios that are possible with the simulated tool; empty if no simulator is installed."""
    return _SIMULATION.get(NAME).scenarios(description) if lab_installed() else ()


@contextmanager
def simulated(description: Description, scenario: str, seed: int = 0) -> Iterator[SimulatedHardware]:
    """Run the same tool on virtual lines for the duration of the context; afterwards no process and no file is left.

    Raises:
        MissingExtraError: no simulator is installed.
        UsageError: the tool cannot have this scenario.
        ReportedError: a process of the simulation does not start.
    """
    if not lab_installed():
        raise lab_needed("--simulate")
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
    """Ignore further signals such as a second Ctrl-C, so that they do not interrupt the end, which takes a few seconds
    at most.
    """
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
