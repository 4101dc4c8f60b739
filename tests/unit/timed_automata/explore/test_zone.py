"""Zones against the set of valuations that they stand for."""

from __future__ import annotations

import pytest
from hypothesis import strategies as st

from tests.unit.timed_automata.explore.valuations import (
    END,
    GRID,
    HIGH,
    UNIT,
    Valuation,
    bounds,
    canonical,
    constraints,
    given,
    inside,
    members,
    satisfies,
    zones,
)
from timed_automata.explore.states._plan import Plan, Rearrangement
from timed_automata.explore.zones import _zone
from timed_automata.explore.zones._zone import AT_MOST_ZERO, INFINITY, LARGEST, at_most, below, negated


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
