"""Measures how long, and for how many samples, a condition has held: every detector needs this memory."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import ClassVar

from ._memory import Remembers, parts_of


class Streak:
    """Counts consecutive samples for which a condition holds, and stores the time of the first one."""

    MEMORY: ClassVar = {"samples": int, "_since": int}

    def __init__(self) -> None:
        self.samples = 0
        self._since = 0

    def take(self, holds: bool, at: int) -> None:
        """Count one more sample, at ``at`` µs."""
        if not holds:
            self.samples = 0
        else:
            if self.samples == 0:
                self._since = at
            self.samples += 1

    def began_within(self, at: int, us: int) -> bool:
        """Return whether the last streak, running or ended, began less than this many µs ago."""
        return at - self._since < us

    def lasted(self, at: int, us: int) -> bool:
        """Return whether the condition has held without a break for at least this many µs."""
        return self.samples > 0 and at - self._since >= us


def streaks_of(thing: Remembers) -> Iterator[Streak]:
    """Yield all streaks of an object and of its parts."""
    for part in parts_of(thing):
        if type(part) is Streak:
            yield part
        else:
            yield from streaks_of(part)


def lengthen(streaks: Iterable[Streak], samples: int) -> None:
    """Add this number of samples to each streak that is running."""
    for streak in streaks:
        if streak.samples:
            streak.samples += samples
