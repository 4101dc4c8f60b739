"""Cancels that overtake their goal: they come over another connection, and may be there first."""

from __future__ import annotations

REMEMBERED = 1000
OVERTAKES_US = 5_000_000


class Cancels:
    """Remembers cancels for goals that are yet to come.

    A cancel by id counts whenever its goal comes; the newest 1000 ids are remembered. A cancel by time counts for
    goals that come within 5 s after it, for it is measured with clocks of other machines, which may be wrong:
    afterwards a goal that is stamped before it comes from a clock that is behind, and was not overtaken.
    """

    def __init__(self) -> None:
        self._ids: dict[str, None] = {}
        self._stamp_ns, self._until_us = 0, 0

    def add(self, goal_id: str, stamp_ns: int, now_us: int) -> None:
        """A cancel came: of an id (empty: none), of all goals up to a stamp (0: none)."""
        if goal_id:
            self._ids.pop(goal_id, None)
            self._ids[goal_id] = None
            if len(self._ids) > REMEMBERED:
                del self._ids[next(iter(self._ids))]
        if stamp_ns:
            before_ns = self._stamp_ns if now_us <= self._until_us else 0
            self._stamp_ns, self._until_us = max(stamp_ns, before_ns), now_us + OVERTAKES_US

    def cover(self, goal_id: str, stamp_ns: int, now_us: int) -> bool:
        """Whether a goal that has just come was cancelled before (a stamp of 0: it has none)."""
        by_time = bool(stamp_ns) and stamp_ns <= self._stamp_ns and now_us <= self._until_us
        return goal_id in self._ids or by_time
