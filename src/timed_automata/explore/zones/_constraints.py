"""Clock constraints of the network as constraints on zones."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from timed_automata.compiler import Bound
from timed_automata.explore.zones._bound import at_most, below
from timed_automata.explore.zones._zone import Constraint


def as_constraints(bounds: Iterable[Bound], places: Mapping[int, int]) -> tuple[Constraint, ...]:
    """Clock constraints over the places of the clocks in a zone."""
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
