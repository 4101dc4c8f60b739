"""ExtraLU+ against its definition: nothing is lost, and what is added a simulation allows."""

from __future__ import annotations

from itertools import product

from hypothesis import strategies as st

from tests.unit.timed_automata.explore.valuations import (
    END,
    UNIT,
    bounded_zones,
    canonical,
    given,
    inside,
    members,
    zones,
)
from timed_automata.explore.zones import _zone
from timed_automata.explore.zones._extrapolation import extrapolated, widening
from timed_automata.explore.zones._limits import NEVER, Limit
from timed_automata.explore.zones._zone import AT_MOST_ZERO, INFINITY, at_most, below

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
