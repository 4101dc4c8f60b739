"""What zones stand for: valuations on a grid fine enough for two clocks and integer bounds."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import Any

import hypothesis
from hypothesis import strategies as st

from timed_automata.explore.zones import _zone
from timed_automata.explore.zones._zone import INFINITY, at_most, below

HIGH = 2  # constants of the zones
UNIT = 6  # a zone of two clocks that is not empty has a point of thirds; what leads there may need sixths
END = UNIT * (2 * HIGH + 1)  # and one no further out than this
GRID = [(0, x, y) for x, y in product(range(0, END + 1, 2), repeat=2)]


def given(*strategies: st.SearchStrategy[Any]) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Hypothesis without its deadline: a grid takes its time on a busy machine."""
    return lambda test: hypothesis.settings(deadline=None)(hypothesis.given(*strategies)(test))


Valuation = tuple[int, ...]  # in 1 / UNIT; x_0 first


def satisfies(valuation: Valuation, constraint: _zone.Constraint) -> bool:
    i, j, bound = constraint
    if bound == INFINITY:
        return True
    difference = valuation[i] - valuation[j]
    return difference <= UNIT * (bound >> 1) if bound & 1 else difference < UNIT * (bound >> 1)


def inside(zone: _zone.Zone | None, valuation: Valuation) -> bool:
    n = len(valuation)
    return zone is not None and all(satisfies(valuation, (at // n, at % n, b)) for at, b in enumerate(zone))


def members(zone: _zone.Zone | None) -> set[Valuation]:
    return {v for v in GRID if inside(zone, v)}


@st.composite
def constraints(draw: st.DrawFn, n: int = 3) -> _zone.Constraint:
    i, j = draw(st.permutations(range(n)))[:2]
    value = draw(st.integers(-HIGH, HIGH))
    return i, j, draw(st.sampled_from((at_most, below)))(value)


@st.composite
def bounds(draw: st.DrawFn, n: int = 3) -> _zone.Constraint:
    """Of one clock."""
    clock, value = draw(st.integers(1, n - 1)), draw(st.integers(0, 2 * HIGH))
    strict = draw(st.sampled_from((at_most, below)))
    return draw(st.sampled_from(((clock, 0, strict(value)), (0, clock, strict(-value)))))


@st.composite
def zones(draw: st.DrawFn, n: int = 3) -> _zone.Zone:
    zone = _zone.everything(n)
    for constraint in draw(st.lists(constraints(n), max_size=2 * n)):
        zone = _zone.constrained(zone, n, [constraint]) or zone
    return zone


@st.composite
def bounded_zones(draw: st.DrawFn, n: int) -> _zone.Zone:
    """Zones around a valuation, with bounds on most differences: what a closure has to do with."""
    values = [0, *draw(st.lists(st.integers(0, 4), min_size=n - 1, max_size=n - 1))]
    slack = st.sampled_from((None, 0, 0, 1, 1, 2, 3))
    zone = _zone.everything(n)
    for i, j in product(range(n), repeat=2):
        more = draw(slack) if i != j else None
        if more is not None:
            zone = _zone.constrained(zone, n, [(i, j, at_most(values[i] - values[j] + more))]) or zone
    return zone


def added(left: int, right: int) -> int:
    """A bound over two bounds."""
    return INFINITY if INFINITY in (left, right) else left + right - ((left | right) & 1)


def canonical(zone: _zone.Zone) -> _zone.Zone:
    """With each bound as tight as the others make it (Floyd and Warshall)."""
    z, n = list(zone), round(len(zone) ** 0.5)
    for k, i, j in product(range(n), repeat=3):
        z[i * n + j] = min(z[i * n + j], added(z[i * n + k], z[k * n + j]))
    return tuple(z)
