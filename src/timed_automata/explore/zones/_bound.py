"""Bounds of clock differences as integers: ``x - y <= c`` is ``2c + 1``, ``x - y < c`` is ``2c``.

So that a tighter bound is a smaller integer and CPython compares bounds at the speed of integers
(Bengtsson and Yi, *Timed Automata: Semantics, Algorithms and Tools*, 2004, section 4).
"""

from __future__ import annotations

INFINITY = 1 << 40  # no bound; more than any sum of bounds that occurs
LARGEST = 1 << 31  # the largest constant that a clock may be compared with
AT_MOST_ZERO = 1  # x - y <= 0


def at_most(value: int) -> int:
    """``<= value``."""
    return 2 * value + 1


def below(value: int) -> int:
    """``< value``."""
    return 2 * value


def negated(bound: int) -> int:
    """The bound on ``y - x`` that says that ``x - y`` is *not* within ``bound``."""
    return 1 - bound
