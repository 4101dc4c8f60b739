"""Runs a tool without hardware by means of the development tools, which a robot does not need."""

from __future__ import annotations

import signal
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from end_effector_hal._extras import lab, lab_installed, lab_needed

if TYPE_CHECKING:
    from end_effector_hal.description import Description


def possible_scenarios(description: Description) -> Iterable[str]:
    """Return the scenarios that are possible with the simulated tool; empty if no simulator is installed."""
    found: Iterable[str] = lab("demo").World.scenarios(description) if lab_installed() else ()
    return found


@contextmanager
def simulated(description: Description, scenario: str, seed: int = 0) -> Iterator[Any]:
    """Run the same tool on virtual lines for the duration of the context, which is a `World` of the demo; afterwards no
    process and no file is left.

    Raises:
        MissingExtraError: no simulator is installed.
        UsageError: the tool cannot have this scenario.
        ReportedError: a process of the simulation does not start.
    """
    if not lab_installed():
        raise lab_needed("--simulate")
    world = lab("demo").World
    with TemporaryDirectory(prefix="eehal-run-", ignore_cleanup_errors=True) as folder:
        hardware = world(description, scenario, Path(folder), outlives_us=False, seed=seed)
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
