"""The tool changer's sensor fault outlives its program: the line arbiter keeps it until a reset (section 6)."""

from __future__ import annotations

import logging
from typing import Any, Protocol

from end_effector_hal.control import Status
from end_effector_hal.errors import WireError
from end_effector_hal.runtime.arbiter import SENSOR_FAULT
from end_effector_hal.vocabulary import ChangerFault

_log = logging.getLogger("end_effector_hal.runtime")


class FaultKeeper(Protocol):
    """What it needs of the line arbiter."""

    def status(self) -> dict[str, Any]:
        """With ``faults``: sentences by name."""

    def latch(self, fault: str, why: str) -> None:
        """Latch one, with a sentence."""

    def clear(self, fault: str) -> None:
        """End one that was latched."""


class SensorFault:
    """Whether the line arbiter keeps it, and what to do about that.

    Args:
        keeper: the line arbiter.
    """

    def __init__(self, keeper: FaultKeeper) -> None:
        self._keeper = keeper
        self._kept = ""  # as the owner has it
        self._is_reset = False

    def found(self) -> bool:
        """Whether one was latched before, which this program takes over; raises WireError."""
        self._is_reset = False
        self._kept = self._keeper.status()["faults"].get(SENSOR_FAULT, "")
        if self._kept:
            self._keeper.latch(SENSOR_FAULT, self._kept)
        return bool(self._kept)

    def reset(self) -> None:
        """The automaton has accepted a reset: the owner clears the fault with the next status that shows none."""
        self._is_reset = True

    def faults_changed(self, faults: tuple[str, ...]) -> None:
        """The owner has these latched now: one that it has lost, and that is still shown, is latched again."""
        if self._kept not in faults:
            self._kept = ""

    def update(self, status: Status) -> None:
        """Latch it as soon as a status shows it, clear it after a reset; what fails now the next status tries again."""
        shown = status.changer_fault == ChangerFault.SENSOR
        try:
            if shown and not self._kept:
                self._keeper.latch(SENSOR_FAULT, status.reason)
                self._kept = status.reason
            elif not shown and self._is_reset:
                self._keeper.clear(SENSOR_FAULT)
                self._kept, self._is_reset = "", False
        except WireError as error:
            _log.warning("the line arbiter could not keep the sensor fault: %s", error)
