"""Stamps of the monotonic clock on one line of time, also when a machine was restarted in the middle of a bag."""

from __future__ import annotations

BACK_US = 2_000_000
"""A stamp further back than this is of a clock that began again."""
AHEAD_US = 3_600_000_000
"""A stamp that is so much further ahead than the bag's own time has moved is of another clock, or is broken."""


class LineOfTime:
    """Places stamps; where the clock jumps, the time at which messages were written down says how long it took.

    Attributes:
        jumps: how often the clock jumped.
    """

    def __init__(self) -> None:
        self.jumps = 0
        self._shift = 0
        self._last: dict[str, tuple[int, int | None]] = {}

    def place(self, stream: str, at: int, log_us: int, *, fresh: bool) -> int:
        """Where a stamp stands, µs.

        Args:
            stream: stamps of one stream are in order.
            at: µs on the monotonic clock of the machine that made it.
            log_us: when the message was written down, µs.
            fresh: whether also the first stamp of the stream was made when its message was published.
        """
        placed = at + self._shift
        if stream not in self._last:
            self._last[stream] = (placed, log_us if fresh else None)
            return placed
        before, since = self._last[stream]
        if placed == before:
            return placed  # a state that is repeated: it was made at the first of them
        passed = 0 if since is None else max(0, log_us - since)
        behind = placed < before - BACK_US
        if behind or (since is not None and placed > before + passed + AHEAD_US):
            self._shift += before + passed - placed
            self.jumps += 1
            placed = before + passed
        self._last[stream] = (placed, log_us)
        return placed
