"""Where a controller stands: with it a recording can begin in the middle of a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from timed_automata import ExecutionSnapshot

from ._status import Status


@dataclass(frozen=True, slots=True)
class ControllerSnapshot:
    """Enough for another controller of the same description to decide the same from here on.

    Attributes:
        at: µs, the latest time that the controller was told.
        status: as it is then, with outputs, evidence, deadline and alarms.
        execution: locations, variables and clocks of the automata.
        memory: of the detectors, the hold monitor and the status: last readings with their times, streaks, alarms.
    """

    at: int
    status: Status
    execution: ExecutionSnapshot
    memory: Mapping[str, Any]
