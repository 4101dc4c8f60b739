"""Places stamps of monotonic clocks on one time axis, even if a machine was restarted in the middle of a bag."""

from __future__ import annotations

BACK_US = 2_000_000
"""A stamp that is further back than this belongs to a restarted clock, µs."""
AHEAD_US = 3_600_000_000
"""A stamp that is further ahead of the bag's own time than this is of another clock, or invalid, µs."""


class LineOfTime:
    """Places stamps on one time axis. When the clock jumps, the recording times of the messages give the elapsed time.

    Attributes:
        jumps: number of jumps of the clock.
    """

    def __init__(self) -> None:
        self.jumps = 0
        self._shift = 0
        self._last: dict[str, tuple[int, int | None]] = {}

    def place(self, stream: str, at: int, log_us: int, *, fresh: bool) -> int:
        """Return the place of a stamp, µs.

        Args:
            stream: name of the stream; the stamps of one stream are in order.
            at: time on the monotonic clock of the machine that made the stamp, µs.
            log_us: time at which the message was recorded, µs.
            fresh: whether the first stamp of the stream was made when its message was published.
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
