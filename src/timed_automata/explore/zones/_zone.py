"""Zones: sets of clock valuations as canonical difference bound matrices.

A zone of n - 1 clocks is a flat tuple of n * n bounds, row by row; entry (i, j) bounds ``x_i - x_j``, and x_0 is zero.
Row 0 holds lower bounds (negated), column 0 upper bounds. Every function takes canonical zones (all bounds as tight as
the others make them) and returns canonical ones, or None for the empty zone. Clocks are never negative. The caller
knows which place belongs to which clock.

Bounds are integers: ``x - y <= c`` is ``2c + 1``, ``x - y < c`` is ``2c``. A tighter bound is a smaller integer, and
CPython compares bounds at the speed of integers (Bengtsson and Yi, *Timed Automata: Semantics, Algorithms and Tools*,
2004, section 4).
"""

from __future__ import annotations

import sys
from array import array
from collections.abc import Iterable, Mapping
from functools import cache
from operator import le

from timed_automata.compiler import Bound

INFINITY = 1 << 40  # no bound; more than any sum of bounds that occurs
LARGEST = 1 << 31  # the largest constant that a clock may be compared with
_POSITIVE = 1 << 42  # added to a bound, it makes any bound a natural number of less than 63 bits
AT_MOST_ZERO = 1  # x - y <= 0


def at_most(value: int) -> int:
    """Return the bound ``<= value``."""
    return 2 * value + 1


def below(value: int) -> int:
    """Return the bound ``< value``."""
    return 2 * value


def negated(bound: int) -> int:
    """Return the bound on ``y - x`` that holds if ``x - y`` is *not* within ``bound``."""
    return 1 - bound


Zone = tuple[int, ...]


class Unique(tuple[int, ...]):
    """A zone that is the only object with its bounds: compared, and looked up, by identity."""

    __slots__ = ()
    __hash__ = object.__hash__
    __eq__ = object.__eq__
    __ne__ = object.__ne__


class UniqueZones:
    """All zones so far, with one unique object for equal bounds.

    A zone is stored under its hash (or the next free number), not under a copy of itself; and equal bounds are one
    object, because a number takes more memory than its place in a zone.
    """

    def __init__(self) -> None:
        self._zones: dict[int, Unique] = {}
        self._bounds: dict[int, int] = {}

    def __len__(self) -> int:
        return len(self._zones)

    def of(self, zone: Zone) -> Unique:
        """Return the unique zone with these bounds."""
        number = hash(zone)
        while (found := self._zones.get(number)) is not None:
            if tuple.__eq__(found, zone):
                return found
            number += 1
        bounds = self._bounds
        found = self._zones[number] = Unique([bounds.setdefault(bound, bound) for bound in zone])
        return found


Constraint = tuple[int, int, int]  # i, j, bound: x_i - x_j within bound
IMPOSSIBLE: Constraint = (0, 0, 0)  # x_0 - x_0 < 0


def as_constraints(bounds: Iterable[Bound], places: Mapping[int, int]) -> tuple[Constraint, ...]:
    """Return clock constraints in the places of the clocks in a zone."""
    found: list[Constraint] = []
    for clock, op, value in bounds:
        place = places[clock]
        if op in ("<", "<="):
            found.append((place, 0, below(value) if op == "<" else at_most(value)))
        elif op in (">", ">="):
            found.append((0, place, below(-value) if op == ">" else at_most(-value)))
        else:
            found += ((place, 0, at_most(value)), (0, place, at_most(-value)))
    return tuple(found)


def everything(n: int) -> Zone:
    """Return the zone of all valuations."""
    row = [INFINITY] * n
    rows = [AT_MOST_ZERO] * n
    for i in range(1, n):
        rows += row
        rows[i * n + i] = AT_MOST_ZERO
    return tuple(rows)


def tighten(z: list[int], n: int, i: int, j: int, bound: int) -> bool:
    """Intersect with ``x_i - x_j`` within ``bound``, in place; return False if nothing is left (``z`` is then
    garbage).

    Only paths through the new bound can become shorter: O(n²), and much less if few do.
    """
    start = i * n
    if bound >= z[start + j]:
        return True
    back = z[j * n + i]
    if back + bound - ((back | bound) & 1) < AT_MOST_ZERO:
        return False
    shorter = []  # columns to which the way over the new bound is shorter
    at = j * n
    for column in range(n):
        on = z[at + column]
        if on != INFINITY:
            on += bound - ((on | bound) & 1)
            if on < z[start + column]:
                shorter.append((column, on))
    at = 0
    for _ in range(n):
        to = z[at + i]
        if to != INFINITY and to + bound - ((to | bound) & 1) < z[at + j]:
            for column, on in shorter:
                over = to + on - ((to | on) & 1)
                if over < z[at + column]:
                    z[at + column] = over
        at += n
    return True


def constrained(zone: Zone, n: int, constraints: Iterable[Constraint]) -> Zone | None:
    """Return the intersection with all constraints, or None if it is empty."""
    z: list[int] | None = None
    for i, j, bound in constraints:
        if z is None:
            if bound >= zone[i * n + j]:
                continue
            z = list(zone)
        if not tighten(z, n, i, j, bound):
            return None
    return zone if z is None else tuple(z)


def included(inner: Zone, outer: Zone) -> bool:
    """Return whether every valuation of ``inner`` is in ``outer``."""
    return all(map(le, inner, outer))


def packed(zone: Zone) -> int:
    """Return all bounds in one integer, 64 bits each; the highest bit of each, the guard bit, stays free.

    ``inner`` lies inside ``outer`` if no bound borrows from its guard bit: ``(packed(outer) + guard_bits(len(outer)) -
    packed(inner))`` still has all of :func:`guard_bits`. One subtraction compares all bounds (Lamport, *Multiple Byte
    Processing with Full-Word Instructions*, 1975).
    """
    return int.from_bytes(array("Q", [bound + _POSITIVE for bound in zone]).tobytes(), sys.byteorder)


@cache
def guard_bits(size: int) -> int:
    """Return the guard bits of ``size`` packed bounds."""
    return int.from_bytes(array("Q", [1 << 63] * size).tobytes(), sys.byteorder)


def intersection(left: Zone, right: Zone, n: int) -> Zone | None:
    """Return the common valuations of two zones, or None if there are none."""
    if included(left, right):
        return left
    return constrained(left, n, constraints_of(right, n))


def constraints_of(zone: Zone, n: int) -> list[Constraint]:
    """Return the bounds of a zone that are a restriction."""
    return [
        (at // n, at % n, bound)
        for at, bound in enumerate(zone)
        if bound != INFINITY and at // n != at % n and (at >= n or bound != AT_MOST_ZERO)
    ]


def up(zone: Zone, n: int) -> Zone:
    """Return the valuations that are reached by letting any time pass."""
    z = list(zone)
    z[n::n] = [INFINITY] * (n - 1)
    return tuple(z)


def delay(z: list[int], n: int, upper: Iterable[tuple[int, int]]) -> None:
    """Let time pass in place, up to the upper bounds (place, bound) that ``z`` satisfies.

    The differences and lower bounds of clocks stay the same; so only paths over the upper bounds become shorter.
    """
    for at in range(n, n * n, n):
        most = INFINITY
        for i, bound in upper:
            more = z[at + i]
            if more != INFINITY:
                over = more + bound - ((more | bound) & 1)
                if over < most:
                    most = over
        z[at] = most


def down(zone: Zone, n: int) -> Zone:
    """Return the valuations from which the zone is reached by letting time pass."""
    z = list(zone)
    for column in range(1, n):
        z[column] = min(AT_MOST_ZERO, *zone[n + column :: n])
    return tuple(z)


def subtract(zone: Zone, other: Iterable[Constraint], n: int) -> list[Zone]:
    """Return the zone without the valuations that satisfy all constraints, as disjoint zones."""
    pieces = []
    rest: Zone | None = zone
    for i, j, bound in other:
        if rest is None or bound >= rest[i * n + j]:
            continue
        piece = constrained(rest, n, ((j, i, negated(bound)),))
        if piece is not None:
            pieces.append(piece)
        rest = constrained(rest, n, ((i, j, bound),))
    return pieces


def unbounded(zone: Zone, n: int) -> bool:
    """Return whether time can pass without end inside the zone."""
    return all(bound == INFINITY for bound in zone[n::n])
