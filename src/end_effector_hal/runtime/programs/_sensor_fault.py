"""The tool changer's sensor fault outlives its program: the line arbiter keeps it until a reset (section 6)."""

from __future__ import annotations

import logging
from typing import Any, Protocol

from end_effector_hal.arbiter import SENSOR_FAULT
from end_effector_hal.control import Status
from end_effector_hal.errors import ReportedError
from end_effector_hal.vocabulary import ChangerFault

_log = logging.getLogger("end_effector_hal.runtime")


class FaultKeeper(Protocol):
    """What it needs of the line arbiter."""

    def status(self) -> dict[str, Any]:
        """With ``faults``: sentences by name."""

    def latch(self, fault: str, why: str) -> None:
        """Latch one, with a sentence; what could not be sent is said with the next connection."""

    def clear(self, fault: str) -> None:
        """End one that was latched; what could not be sent is said with the next connection."""


class SensorFault:
    """Has the line arbiter latch it when the program shows it, and clear it when the program was reset.

    Args:
        keeper: the line arbiter.
    """

    def __init__(self, keeper: FaultKeeper) -> None:
        self._keeper = keeper
        self._is_latched = self._is_reset = self._was_found = False

    def found(self) -> bool:
        """Whether one was latched before; raises WireError."""
        self._is_latched = self._is_reset = False
        self._was_found = self._is_kept()
        return self._was_found

    def came_late(self) -> bool:
        """Whether one is latched that was not `found` and that the program has not shown; raises WireError."""
        return not (self._was_found or self._is_latched) and self._is_kept()

    def reset(self) -> None:
        """The automaton has accepted a reset: the next status that shows no fault clears it."""
        self._is_reset = True

    def restarted(self) -> None:
        """The program has restarted: a reset before it clears nothing."""
        self._is_reset = False

    def update(self, status: Status) -> None:
        """A status is published. One that shows none and follows no reset clears nothing: a restart begins so."""
        shown = status.changer_fault == ChangerFault.SENSOR
        try:
            if shown and not self._is_latched:
                self._is_latched = True
                self._keeper.latch(SENSOR_FAULT, status.reason)
            elif not shown and self._is_reset:
                self._is_latched = self._is_reset = self._was_found = False
                self._keeper.clear(SENSOR_FAULT)
        except ReportedError as error:
            _log.warning("the line arbiter gets the sensor fault when it is back: %s", error)

    def _is_kept(self) -> bool:
        return SENSOR_FAULT in self._keeper.status()["faults"]
