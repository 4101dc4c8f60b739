"""Finds the smallest case that still fails for the same reason: delta debugging over its events, then
simpler values.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence

from end_effector_hal.description import Description

from ._case import SCENARIO, Case, Happening
from ._coverage import CoverageMap
from ._play import play_case

MOST_PLAYS = 300
MOST_S = 60.0
"""Longest time for shrinking, s: one play of a large tool takes seconds, and the smallest case found by then is
useful.
"""


def shrunk(
    description: Description, case: Case, same: Callable[[Mapping[str, str]], bool], known: CoverageMap
) -> Case:
    """Return the smallest case found within `MOST_S` for whose failures ``same`` is true; it is true for the case
    itself.
    """
    until = time.monotonic() + MOST_S

    def fails(tried: Case) -> bool:
        return time.monotonic() < until and same(play_case(description, tried, known, enough=same).failures)

    return shrunk_by(case, fails)


def shrunk_by(case: Case, fails: Callable[[Case], bool], most: int = MOST_PLAYS) -> Case:
    """Return the smallest case found for which ``fails`` is true, with at most ``most`` calls; it is true for
    ``case``.
    """
    asked: dict[Case, bool] = {case: True}

    def asks(tried: Case) -> bool:
        if tried not in asked:
            asked[tried] = len(asked) <= most and fails(tried)
        return asked[tried]

    before = None
    while case != before:
        before = case
        case = _with_fewer(case, asks)
        for tried in _simpler(case):
            if asks(tried):
                case = tried
                break
    return case


def _with_fewer(case: Case, fails: Callable[[Case], bool]) -> Case:
    """Leave out halves, then quarters, down to single events: delta debugging (Zeller and Hildebrandt, 2002)."""
    left, parts = case.happenings, 2
    while left:
        parts = min(parts, len(left))
        size = -(-len(left) // parts)
        for at in range(0, len(left), size):
            fewer = left[:at] + left[at + size :]
            if fails(Case(case.seed, fewer)):
                left, parts = fewer, max(parts - 1, 2)
                break
        else:
            if parts >= len(left):
                break
            parts *= 2
    return Case(case.seed, left)


def _simpler(case: Case) -> Iterator[Case]:
    """Yield the case with one simplification, the largest first."""
    yield from _if_other(case, Case(0, case.happenings))
    for place, each in enumerate(case.happenings):
        for what in _simpler_words(each):
            yield from _if_other(case, _replaced(case, place, each._replace(what=what)))
    for place in range(len(case.happenings)):
        before = case.happenings[place - 1].at if place else 0
        gap = case.happenings[place].at - before
        for simpler in _rounder(gap):
            yield _moved(case, place, simpler - gap)


def _if_other(case: Case, tried: Case) -> Iterator[Case]:
    if tried != case:
        yield tried


def _simpler_words(each: Happening) -> Iterator[str]:
    """Yield the event with fewer simultaneous faults."""
    parts = each.rest.split(",")
    if each.verb == SCENARIO and len(parts) > 1:
        yield from (f"{SCENARIO} {part.strip()}" for part in parts)


def _rounder(gap: int) -> Iterator[int]:
    """Yield shorter or rounder waits, µs; each is smaller, or has fewer digits, so that shrinking ends."""
    found: Sequence[int] = (0, *(gap // unit * unit for unit in (1_000_000, 500_000, 100_000, 10_000, 1_000)))
    yield from sorted({each for each in found if each < gap})


def _moved(case: Case, place: int, by: int) -> Case:
    """Return the case with all events from a position on moved by ``by`` µs."""
    later = (each._replace(at=each.at + by) for each in case.happenings[place:])
    return Case(case.seed, (*case.happenings[:place], *later))


def _replaced(case: Case, place: int, happening: Happening) -> Case:
    return Case(case.seed, (*case.happenings[:place], happening, *case.happenings[place + 1 :]))
