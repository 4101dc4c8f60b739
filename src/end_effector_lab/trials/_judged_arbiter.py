"""The judge's view of the line arbiter: when it lives, and which faults it has latched."""

from __future__ import annotations

from collections.abc import Iterator

from end_effector_hal.arbiter import HAL, SENSOR_FAULT
from end_effector_hal.control import Answer
from end_effector_hal.vocabulary import ChangerFault, ChangerState
from end_effector_lab.virtual import VirtualTool

from ._reality import Reality

HEARD_US = 1_000_000
"""Time within which the program reports its wishes to a restarted arbiter, µs."""


class JudgedArbiter:
    """The successive line arbiters of a tool, as the judge sees them.

    Attributes:
        since: start of the present or last arbiter, µs.
        until: end of the last arbiter that has ended, µs.
    """

    def __init__(self, tool: VirtualTool, reality: Reality) -> None:
        self._tool, self._reality = tool, reality
        self._life: int | None = tool.arbiters
        self.since = self.until = tool.at
        self._latched: set[str] = set()
        self._sensor_fault = False
        self._changer_is_reset = False

    # When it lives

    @property
    def lives(self) -> bool:
        """Whether an arbiter is running now."""
        return "arbiter" in self._tool.living

    def look(self) -> tuple[bool, bool]:
        """Return whether an arbiter has ended, and whether one has started, since the last call."""
        before, self._life = self._life, self._tool.arbiters if self.lives else None
        if self._life == before:
            return False, False
        if before is not None:
            self.until = self._tool.at
        if self._life is not None:
            self.since = self._tool.at
        return before is not None, self._life is not None

    def has_lived_since(self, at: int) -> bool:
        """Return whether the arbiter has lived since ``at`` (µs); otherwise lines may be switched later than
        requested.
        """
        return self.lives and self.since <= at

    def has_heard_of(self, release: int) -> bool:
        """Return whether the arbiter has received the last will of a release of that time (µs); otherwise it has the
        previous one.
        """
        until = self._tool.at if self.lives else self.until
        if self.since <= release and (self.lives or release < until):
            return True
        return until - max(self.since, release) > HEARD_US

    # What it has latched

    def reset(self, answer: Answer) -> None:
        """Process a reset; a refused one clears everything except the persisting faults."""
        self._latched = set(self._tool.latched)
        if answer.accepted or (answer.decided and HAL not in self._tool.living):
            self._sensor_fault, self._changer_is_reset = False, True

    def forget(self) -> None:
        """Process a loss of the arbiter's data."""
        self._latched, self._sensor_fault = set(), False

    def unlatched(self) -> Iterator[str]:
        """Yield a sentence about every fault that is no longer latched although no reset was given."""
        tool, latched = self._tool, set(self._tool.latched)
        if tool.statuses[-1].changer_fault == ChangerFault.SENSOR:
            self._changer_is_reset = False
        again = {
            f"output {line}" for line, active in tool.levels.items() if active
        }  # activated since, as commanded
        gone = self._latched - latched - again - ({SENSOR_FAULT} if self._changer_is_reset else set())
        if gone:
            yield f"{', '.join(sorted(gone))} is latched no more, without a reset"
        self._latched = latched
        self._sensor_fault = self._sensor_fault or self._reality.lasts("sensor fault")
        changer = tool.statuses[-1].changer if HAL in tool.living else ChangerState.UNKNOWN
        if self._sensor_fault and changer in (ChangerState.LOCKED, ChangerState.UNLOCKED):
            yield f"the tool changer is {changer.name} after a sensor fault, without a reset (IL-04)"
