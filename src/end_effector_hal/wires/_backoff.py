"""Waiting times between tries after a failure."""

from __future__ import annotations

from collections.abc import Callable

from ._clock import now_us

FIRST_WAIT_S, LONGEST_WAIT_S = 0.1, 5.0


class Backoff:
    """Waits 0.1 s after a failure, doubling with each further one up to 5 s.

    Args:
        clock: µs.
    """

    def __init__(self, clock: Callable[[], int] = now_us) -> None:
        self._clock = clock
        self._next = 0
        self._wait_s = FIRST_WAIT_S

    def is_due(self) -> bool:
        """Return whether the next try may be made now."""
        return self._clock() >= self._next

    def failed(self) -> None:
        """Start the next wait, twice as long as the last one."""
        self._next = self._clock() + round(self._wait_s * 1e6)
        self._wait_s = min(2 * self._wait_s, LONGEST_WAIT_S)

    def worked(self) -> None:
        """Reset the waiting time after a success."""
        self._next, self._wait_s = 0, FIRST_WAIT_S
