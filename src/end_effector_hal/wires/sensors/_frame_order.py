"""One order of the frames of several readers."""

from __future__ import annotations

from dataclasses import replace

from end_effector_hal.signals import Frame

MOST_OVERTAKEN_US = 20_000
"""Threads of two sources take turns within this; what waited longer was heard long before (a relay's backlog)."""


class FrameOrder:
    """Gives a frame that was overtaken on its way the stamp of the newest one: it is news, and is judged after that.

    One that is older by more than 20 ms, and what its source waits, keeps its stamp: what judges frames refuses it, and
    says so.
    """

    def __init__(self) -> None:
        self._last = 0

    def next(self, frame: Frame, waits_us: int = 0) -> Frame:
        """The frame as it is judged.

        Args:
            frame: as it came.
            waits_us: so long its source may go on waiting for others after it has heard the last of it.
        """
        if 0 < self._last - frame.at <= MOST_OVERTAKEN_US + waits_us:
            return replace(frame, at=self._last)
        self._last = max(self._last, frame.at)
        return frame
