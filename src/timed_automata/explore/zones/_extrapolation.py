"""ExtraLU+: widens a zone by valuations that no guard can distinguish, so that there are finitely many zones.

Behrmann, Bouyer, Larsen, Pelánek, *Lower and Upper Bounds in Zone-Based Abstractions of Timed Automata*, 2006,
definition 4. With equal lower and upper limits it is ExtraM+.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from timed_automata.explore.zones._limits import NEVER, Limit
from timed_automata.explore.zones._zone import AT_MOST_ZERO, INFINITY, Zone, at_most, below


class Widening(NamedTuple):
    """Limits as bounds, indexed by the place of a clock in the zone; index 0 is x_0.

    Attributes:
        lower_at_most: ``x <= lower limit``; an upper bound above it is dropped.
        past_lower: ``-x <= -lower limit``; a lower bound tighter than it is past the lower limit.
        past_upper: the same for the upper limit.
        kept: the lower bound that is kept when past the upper limit.
    """

    lower_at_most: tuple[int, ...]
    past_lower: tuple[int, ...]
    past_upper: tuple[int, ...]
    kept: tuple[int, ...]


def widening(limits: Iterable[Limit]) -> Widening:
    """Return the widening for the limits of the clocks x_1, x_2, …"""
    limits = tuple(limits)
    past = {NEVER: INFINITY}  # any lower bound is past a limit that does not exist
    return Widening(
        (AT_MOST_ZERO, *(at_most(lower) if lower != NEVER else -INFINITY for lower, _ in limits)),
        (-INFINITY, *(past.get(lower, at_most(-lower)) for lower, _ in limits)),
        (-INFINITY, *(past.get(upper, at_most(-upper)) for _, upper in limits)),
        (AT_MOST_ZERO, *(below(-upper) if upper != NEVER else AT_MOST_ZERO for _, upper in limits)),
    )


def extrapolated(zone: list[int], n: int, limits: Widening) -> Zone:
    """Return the widened zone in canonical form; ``zone`` is changed."""
    lower_at_most, past_lower, past_upper, kept = limits
    lower = zone[:n]
    whole = [INFINITY] * n
    past = [j for j in range(1, n) if lower[j] < past_upper[j]]
    for j in past:
        zone[j] = max(kept[j], lower[j])
    rows = [0]  # from which a bound leads on
    loosened = []
    for i in range(1, n):
        at = i * n
        if lower[i] < past_lower[i]:
            zone[at : at + n] = whole
            zone[at + i] = AT_MOST_ZERO
            continue
        rows.append(i)
        most = lower_at_most[i]
        columns = [j for j, bound in enumerate(zone[at : at + n]) if most < bound != INFINITY]
        if columns:
            loosened.append((at, columns))
            for j in columns:
                zone[at + j] = INFINITY
    if loosened:
        _close(zone, n, [k for k in rows if k not in past], loosened)
    # to what is past its upper limit only a lower bound leads, so no bound is tighter for it
    for at in [i * n for i in rows[1:]] if past else ():
        upper = zone[at]
        for j in past:
            if at + j != j * (n + 1):
                low = zone[j]
                zone[at + j] = INFINITY if upper == INFINITY else upper + low - ((upper | low) & 1)
    return tuple(zone)


def _close(zone: list[int], n: int, rows: list[int], loosened: list[tuple[int, list[int]]]) -> None:
    """Restore the canonical form in place after some bounds (start of a row, columns) were loosened.

    It runs Floyd and Warshall's algorithm over ``rows`` for the loosened bounds only: the others are as tight as
    before, and a row without bounds neither gets one nor leads to one.
    """
    for k in rows:
        on = zone[k * n : k * n + n]
        for at, columns in loosened:
            to = zone[at + k]
            if to == INFINITY:
                continue
            for column in columns:
                then = on[column]
                if then != INFINITY:
                    over = to + then - ((to | then) & 1)
                    if over < zone[at + column]:
                        zone[at + column] = over
