"""Functions that compare unions of zones."""

from __future__ import annotations

from collections.abc import Sequence

from timed_automata.explore.zones import Zone, constraints_of, subtract


def outside(zone: Zone, others: Sequence[Zone], n: int) -> list[Zone]:
    """Return the parts of a zone that lie in none of the others."""
    left = [zone]
    for other in others:
        constraints = constraints_of(other, n)
        left = [piece for part in left for piece in subtract(part, constraints, n)]
        if not left:
            break
    return left


def same_union(left: Sequence[Zone], right: Sequence[Zone], n: int) -> bool:
    """Return whether two unions of zones contain the same valuations."""
    return not any(outside(zone, right, n) for zone in left) and not any(
        outside(zone, left, n) for zone in right
    )
