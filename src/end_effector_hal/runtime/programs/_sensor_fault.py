"""Store the tool changer's sensor fault at the line arbiter, where it survives its program (section 6)."""

from __future__ import annotations

import logging
from typing import Any, Protocol

from end_effector_hal.arbiter import SENSOR_FAULT
from end_effector_hal.control import Status
from end_effector_hal.errors import ReportedError
from end_effector_hal.vocabulary import ChangerFault

_log = logging.getLogger("end_effector_hal.runtime")


class FaultKeeper(Protocol):
    """The methods of the line arbiter that `SensorFault` calls."""

    def status(self) -> dict[str, Any]:
        """Return the status, whose ``faults`` are sentences by name."""

    def latch(self, fault: str, why: str) -> None:
        """Latch a fault, with a sentence; if it cannot be sent, it is sent with the next connection."""

    def clear(self, fault: str) -> None:
        """Clear a latched fault; if the request cannot be sent, it is sent with the next connection."""


class SensorFault:
    """Latches the sensor fault at the line arbiter when the program shows it, and clears it after a reset.

    Args:
        keeper: the line arbiter.
    """

    def __init__(self, keeper: FaultKeeper) -> None:
        self._keeper = keeper
        self._is_latched = self._is_reset = self._was_found = False

    def found(self) -> bool:
        """Return whether a sensor fault was latched before; raises WireError."""
        self._is_latched = self._is_reset = False
        self._was_found = self._is_kept()
        return self._was_found

    def came_late(self) -> bool:
        """Return whether a fault is latched that `found` did not see and the program has not shown; raises
        WireError.
        """
        return not (self._was_found or self._is_latched) and self._is_kept()

    def reset(self) -> None:
        """Note that the automaton has accepted a reset: the next status without a fault clears the latched one."""
        self._is_reset = True

    def restarted(self) -> None:
        """Note that the program has restarted: an earlier reset clears nothing."""
        self._is_reset = False

    def update(self, status: Status) -> None:
        """Latch or clear the fault as a published status shows it.

        A status without a fault clears nothing unless a reset came before it, because a restart begins with one.
        """
        shown = status.changer_fault == ChangerFault.SENSOR
        try:
            if shown and not self._is_latched:
                self._is_latched = True
                self._keeper.latch(SENSOR_FAULT, status.changer_reason)
            elif not shown and self._is_reset:
                self._is_latched = self._is_reset = self._was_found = False
                self._keeper.clear(SENSOR_FAULT)
        except ReportedError as error:
            _log.warning("the line arbiter gets the sensor fault when it is back: %s", error)

    def _is_kept(self) -> bool:
        return SENSOR_FAULT in self._keeper.status()["faults"]
