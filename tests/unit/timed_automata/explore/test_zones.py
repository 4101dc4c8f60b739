"""Zones against the set of valuations that they stand for: a grid fine enough for two clocks and integer bounds."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import Any

import hypothesis
import pytest
from hypothesis import strategies as st

from timed_automata.explore.states._plan import Plan, Rearrangement
from timed_automata.explore.zones import _zone
from timed_automata.explore.zones._extrapolation import extrapolated, widening
from timed_automata.explore.zones._limits import NEVER, Limit
from timed_automata.explore.zones._zone import AT_MOST_ZERO, INFINITY, LARGEST, at_most, below, negated

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


# Zones against the set of valuations that they stand for.


def test_bounds_are_ordered_by_tightness_and_add_up() -> None:
    assert below(3) < at_most(3) < below(4) < INFINITY
    assert negated(at_most(3)) == below(-3)
    assert negated(below(3)) == at_most(-3)
    assert at_most(0) == AT_MOST_ZERO


@given(zones(), st.lists(constraints(), max_size=4))
def test_and_with_constraints(zone: _zone.Zone, more: list[_zone.Constraint]) -> None:
    result = _zone.constrained(zone, 3, more)
    assert members(result) == {v for v in members(zone) if all(satisfies(v, c) for c in more)}
    assert (result is None) == (not members(result))


@given(st.data(), st.integers(2, 5))
def test_the_incremental_closure_is_the_whole_one(data: st.DataObject, n: int) -> None:
    zone = data.draw(zones(n))
    i, j, bound = data.draw(constraints(n))
    assert canonical(zone) == zone
    tighter = list(zone)
    tighter[i * n + j] = min(tighter[i * n + j], bound)
    whole = canonical(tuple(tighter))
    result = _zone.constrained(zone, n, [(i, j, bound)])
    assert result == (whole if all(whole[k * n + k] >= AT_MOST_ZERO for k in range(n)) else None)


@given(zones(), zones())
def test_intersection_and_inclusion(left: _zone.Zone, right: _zone.Zone) -> None:
    assert members(_zone.intersection(left, right, 3)) == members(left) & members(right)
    assert _zone.included(left, right) == (members(left) <= members(right))


@given(st.data(), st.integers(1, 5))
def test_one_subtraction_of_packed_zones_says_whether_one_lies_inside_the_other(
    data: st.DataObject, n: int
) -> None:
    bound = st.sampled_from((-2 * LARGEST, -1, 0, 1, 2, 2 * LARGEST + 1, INFINITY))
    inner, outer = (tuple(data.draw(st.lists(bound, min_size=n * n, max_size=n * n))) for _ in range(2))
    guards = _zone.guard_bits(n * n)
    differences = _zone.packed(outer) + guards - _zone.packed(inner)
    assert (differences & guards == guards) == _zone.included(inner, outer)


def later(v: Valuation, time: int) -> Valuation:
    return 0, v[1] + time, v[2] + time


@given(zones())
def test_up_is_what_time_leads_to(zone: _zone.Zone) -> None:
    result = _zone.up(zone, 3)
    assert result == canonical(result)
    assert members(result) == {
        v for v in GRID if any(inside(zone, later(v, -d)) for d in range(min(v[1:]) + 1))
    }


@given(zones())
def test_down_is_what_time_leads_from(zone: _zone.Zone) -> None:
    result = _zone.down(zone, 3)
    assert result == canonical(result)
    assert members(result) == {v for v in GRID if any(inside(zone, later(v, d)) for d in range(END))}


def put(v: Valuation, clock: int, value: int) -> Valuation:
    return tuple(value if at == clock else x for at, x in enumerate(v))


@given(st.data(), st.integers(2, 4))
def test_a_delay_up_to_an_invariant(data: st.DataObject, n: int) -> None:
    """Upper and lower bounds; a zone that was widened may lie beyond them."""
    zone, invariant = data.draw(zones(n)), data.draw(st.lists(bounds(n), max_size=4))
    lasting = [constraint for constraint in invariant if not constraint[1]]
    expected = _zone.constrained(_zone.up(zone, n), n, invariant)
    sources = [(at, 0) for at in range(n)]
    assert Plan((), Rearrangement(n, sources), True, tuple(invariant), None)(zone) == expected
    inside_ = _zone.constrained(zone, n, lasting)
    if inside_ is not None:
        delayed = list(inside_)
        _zone.delay(delayed, n, [(i, bound) for i, _, bound in lasting])
        assert tuple(delayed) == _zone.constrained(_zone.up(zone, n), n, lasting)


@given(zones(), st.integers(1, 2), st.integers(0, HIGH))
def test_a_plan_sets_a_clock_to_a_value(zone: _zone.Zone, clock: int, value: int) -> None:
    sources = [(0, value) if at == clock else (at, 0) for at in range(3)]
    result = Plan((), Rearrangement(3, sources), False, (), None)(zone)
    expected = {
        v
        for v in GRID
        if v[clock] == value * UNIT and any(inside(zone, put(v, clock, x)) for x in range(2 * END))
    }
    assert result == canonical(result)
    assert members(result) == expected


@given(zones(), st.integers(1, 2))
def test_a_plan_drops_a_clock(zone: _zone.Zone, clock: int) -> None:
    other = 3 - clock
    result = Plan((), Rearrangement(3, [(0, 0), (other, 0)]), False, (), None)(zone)
    assert result is not None
    assert result == canonical(result)
    assert {v for v in GRID if inside(result, (0, v[other]))} == {
        v for v in GRID if any(inside(zone, put(v, clock, x)) for x in range(2 * END))
    }


@given(zones(), st.lists(constraints(), max_size=4))
def test_subtraction_leaves_the_rest_in_disjoint_zones(
    zone: _zone.Zone, other: list[_zone.Constraint]
) -> None:
    pieces = [members(piece) for piece in _zone.subtract(zone, other, 3)]
    expected = {v for v in members(zone) if not all(satisfies(v, c) for c in other)}
    assert sum(map(len, pieces)) == len(expected)
    assert set().union(*pieces) == expected


@given(zones())
def test_a_zone_can_be_told_by_its_constraints(zone: _zone.Zone) -> None:
    assert _zone.constrained(_zone.everything(3), 3, _zone.constraints_of(zone, 3)) == zone


@pytest.mark.parametrize("n", [1, 2, 5])
def test_origin_and_everything_are_canonical(n: int) -> None:
    origin = (AT_MOST_ZERO,) * (n * n)
    for zone in (origin, _zone.everything(n)):
        assert canonical(zone) == zone
    assert _zone.included(origin, _zone.everything(n))
    assert _zone.unbounded(_zone.everything(n), n)
    assert _zone.unbounded(_zone.up(origin, n), n)
    assert n == 1 or not _zone.unbounded(origin, n)


# ExtraLU+ against its definition: nothing is lost, and what is added a simulation allows.


limit = st.builds(Limit, st.integers(NEVER, 3), st.integers(NEVER, 3))
limits = st.tuples(limit, limit)


def widened(zone: _zone.Zone, bounds: tuple[Limit, ...]) -> _zone.Zone:
    return extrapolated(list(zone), len(bounds) + 1, widening(bounds))


def simulated(v: tuple[int, ...], w: tuple[int, ...], bounds: tuple[Limit, ...]) -> bool:
    """Whether w can do whatever v can, as far as lower and upper limits tell (in units of the grid)."""
    return all(
        b == a or UNIT * lower < b < a or UNIT * upper < a < b
        for (lower, upper), a, b in zip(bounds, v[1:], w[1:], strict=True)
    )


@given(zones(), limits)
def test_it_only_adds_what_a_valuation_inside_simulates(
    zone: _zone.Zone, bounds: tuple[Limit, Limit]
) -> None:
    result = widened(zone, bounds)
    assert _zone.included(zone, result)
    assert result == canonical(result)
    wide = range(2 * END)  # what simulates may lie further out, and between the points
    for v in members(result) - members(zone):
        columns = [
            [w for w in wide if simulated((0, x), (0, w), (bound,))]
            for x, bound in zip(v[1:], bounds, strict=True)
        ]
        assert any(inside(zone, (0, *w)) for w in product(*columns)), v


@given(st.data(), st.integers(2, 5))
def test_it_is_the_definition_made_canonical(data: st.DataObject, n: int) -> None:
    """Definition 4, bound by bound, and then the closure of all of it."""
    zone = data.draw(bounded_zones(n))
    bounds = data.draw(st.lists(limit, min_size=n - 1, max_size=n - 1))
    lower, upper = ([0, *(each[at] for each in bounds)] for at in (0, 1))

    def past(clock: int, limit: int) -> bool:
        """Whether all of the zone is past a limit of a clock."""
        return clock > 0 and (limit == NEVER or zone[clock] < at_most(-limit))

    def loosened(i: int, j: int) -> int:
        bound = zone[i * n + j]
        if i == j:
            return bound
        if i and (past(i, lower[i]) or bound > at_most(lower[i])):
            return INFINITY
        if not past(j, upper[j]):
            return bound
        return INFINITY if i else max(bound, AT_MOST_ZERO if upper[j] == NEVER else below(-upper[j]))

    expected = canonical(tuple(loosened(i, j) for i in range(n) for j in range(n)))
    assert widened(zone, tuple(bounds)) == expected


def test_the_definition_case_by_case() -> None:
    # 5 <= x <= 7, 2 <= y <= 3
    zone = _zone.constrained(
        _zone.everything(3),
        3,
        [(1, 0, at_most(7)), (0, 1, at_most(-5)), (2, 0, at_most(3)), (0, 2, at_most(-2))],
    )
    assert zone is not None
    assert widened(zone, (Limit(7, 5), Limit(3, 2))) == zone  # all within
    (x_upper, x_lower) = (widened(zone, (Limit(6, 4), Limit(3, 2)))[at] for at in (3, 1))
    assert (x_upper, x_lower) == (
        at_most(8),
        -2 * 4,
    )  # of its own bounds only "more than 4"; x <= y + 5 stays
    assert widened(zone, (Limit(4, 5), Limit(3, 2)))[3] == INFINITY  # past its lower limit altogether
    assert widened(zone, (Limit(NEVER, NEVER),) * 2) == _zone.everything(3)
