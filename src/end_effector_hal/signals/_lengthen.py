"""Samples that are known to be like the last one need not be taken one by one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ._memory import Remembers, parts_of
from ._streak import Streak


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
