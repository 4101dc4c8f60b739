"""When to try again what has failed."""

from __future__ import annotations

from collections.abc import Callable

from ._clock import now_us

FIRST_WAIT_S, LONGEST_WAIT_S = 0.1, 5.0


class Backoff:
    """After a failure 0.1 s, doubling up to 5 s.

    Args:
        clock: µs.
    """

    def __init__(self, clock: Callable[[], int] = now_us) -> None:
        self._clock = clock
        self._next = 0
        self._wait_s = FIRST_WAIT_S

    def is_due(self) -> bool:
        """Whether it may be tried now."""
        return self._clock() >= self._next

    def failed(self) -> None:
        """Wait longer than the last time."""
        self._next = self._clock() + round(self._wait_s * 1e6)
        self._wait_s = min(2 * self._wait_s, LONGEST_WAIT_S)

    def worked(self) -> None:
        """The next failure is the first."""
        self._next, self._wait_s = 0, FIRST_WAIT_S
