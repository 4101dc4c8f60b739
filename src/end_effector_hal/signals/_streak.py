"""How long, and for how many samples, something has been so: the memory that every detector needs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import ClassVar

from ._memory import Remembers, parts_of


class Streak:
    """Counts consecutive samples for which a condition holds, and since when."""

    MEMORY: ClassVar = {"samples": int, "_since": int}

    def __init__(self) -> None:
        self.samples = 0
        self._since = 0

    def take(self, holds: bool, at: int) -> None:
        """One more sample, at a time in µs."""
        if not holds:
            self.samples = 0
        else:
            if self.samples == 0:
                self._since = at
            self.samples += 1

    def began_within(self, at: int, us: int) -> bool:
        """Whether the last one, that which runs or one that has ended, began less than so many µs ago."""
        return at - self._since < us

    def lasted(self, at: int, us: int) -> bool:
        """Whether it has held without a break for at least so many µs."""
        return self.samples > 0 and at - self._since >= us


def streaks_of(thing: Remembers) -> Iterator[Streak]:
    """All that an object counts with."""
    for part in parts_of(thing):
        if type(part) is Streak:
            yield part
        else:
            yield from streaks_of(part)


def lengthen(streaks: Iterable[Streak], samples: int) -> None:
    """Have each of them that runs count so many samples more."""
    for streak in streaks:
        if streak.samples:
            streak.samples += samples
