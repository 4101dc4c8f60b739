"""One order of the frames of several readers."""

from __future__ import annotations

from dataclasses import replace

from end_effector_hal.signals import Frame

MOST_OVERTAKEN_US = 20_000
"""Threads of two sources take turns within this; what waited longer was heard long before (a relay's backlog)."""


class FrameOrder:
    """Gives a frame that was overtaken on its way the stamp of the newest one: it is news, and is judged after that.

    A frame that other sources have overtaken by more than 20 ms, and what its source waits, keeps its stamp: the
    machine was late, and the frame is as old as it is. One that its own source has overtaken by more than that keeps
    its stamp as well: what judges frames refuses it, and says so.
    """

    def __init__(self) -> None:
        self._last = 0
        self._came: dict[str, int] = {}
        self._given: dict[str, int] = {}

    def next(self, frame: Frame, source: str = "", waits_us: int = 0) -> Frame:
        """The frame as it is judged.

        Args:
            frame: as it came.
            source: who brought it; stamps of one source are in order, but for moments.
            waits_us: so long its source may go on waiting for others after it has heard the last of it.
        """
        came = self._came.get(source, 0)
        if came - frame.at > MOST_OVERTAKEN_US + waits_us:
            return frame
        self._came[source] = max(came, frame.at)
        overtaken = 0 < self._last - frame.at <= MOST_OVERTAKEN_US + waits_us
        at = self._last if overtaken else max(frame.at, self._given.get(source, 0))
        self._given[source], self._last = at, max(self._last, at)
        return replace(frame, at=at) if at != frame.at else frame
