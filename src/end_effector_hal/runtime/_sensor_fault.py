"""The tool changer's sensor fault outlives its program: the line arbiter keeps it until a reset (section 6)."""

from __future__ import annotations

import logging
from typing import Any, Protocol

from end_effector_hal.control import Status
from end_effector_hal.errors import WireError
from end_effector_hal.vocabulary import ChangerFault

from ._lines import SENSOR_FAULT

_log = logging.getLogger("end_effector_hal.runtime")


class Keeper(Protocol):
    """What it needs of the line arbiter."""

    def status(self) -> dict[str, Any]:
        """With ``faults``: sentences by name."""

    def latch(self, fault: str, why: str) -> None:
        """Keep one."""


class SensorFault:
    """Of one program; ``owner`` None: nothing is kept.

    Args:
        owner: the line arbiter.
    """

    def __init__(self, owner: Keeper | None = None) -> None:
        self._owner = owner
        self._kept = ""  # as the owner has it

    def found(self) -> bool:
        """Whether one was latched before; raises WireError."""
        self._kept = self._owner.status()["faults"].get(SENSOR_FAULT, "") if self._owner is not None else ""
        return bool(self._kept)

    def heard(self, faults: tuple[str, ...]) -> None:
        """What the owner has latched now: what a reset took from it, and is still shown, is kept anew."""
        if self._kept not in faults:
            self._kept = ""

    def see(self, status: Status) -> None:
        """Have it kept as soon as a status shows it; one that cannot be kept now is tried again."""
        shown = status.changer_fault == ChangerFault.SENSOR
        if self._owner is None or shown == bool(self._kept):
            return
        try:
            if shown:
                self._owner.latch(SENSOR_FAULT, status.reason)
            self._kept = status.reason if shown else ""
        except WireError as error:
            _log.warning("the line arbiter could not keep the sensor fault: %s", error)
