"""ExtraLU+: a zone widened by what no guard can distinguish, so that there are finitely many zones.

Behrmann, Bouyer, Larsen, Pelánek, *Lower and Upper Bounds in Zone-Based Abstractions of Timed Automata*, 2006,
definition 4. With equal lower and upper limits it is ExtraM+.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from timed_automata.explore.zones._limits import NEVER, Limit
from timed_automata.explore.zones._zone import AT_MOST_ZERO, INFINITY, Zone, at_most, below


class Widening(NamedTuple):
    """Limits as bounds, each indexed by the place of a clock in the zone; index 0 is x_0.

    Attributes:
        lower_at_most: ``x <= lower limit``: upper bounds above it say nothing.
        past_lower: ``-x <= -lower limit``: a lower bound tighter than it is past the lower limit.
        past_upper: the same for the upper limit.
        kept: the lower bound that is kept when past the upper limit.
    """

    lower_at_most: tuple[int, ...]
    past_lower: tuple[int, ...]
    past_upper: tuple[int, ...]
    kept: tuple[int, ...]


def widening(limits: Iterable[Limit]) -> Widening:
    """The widening by the limits of the clocks x_1, x_2, …"""
    limits = tuple(limits)
    past = {NEVER: INFINITY}  # any lower bound is past a limit that does not exist
    return Widening(
        (AT_MOST_ZERO, *(at_most(lower) if lower != NEVER else -INFINITY for lower, _ in limits)),
        (-INFINITY, *(past.get(lower, at_most(-lower)) for lower, _ in limits)),
        (-INFINITY, *(past.get(upper, at_most(-upper)) for _, upper in limits)),
        (AT_MOST_ZERO, *(below(-upper) if upper != NEVER else AT_MOST_ZERO for _, upper in limits)),
    )


def extrapolated(zone: list[int], n: int, limits: Widening) -> Zone:
    """The widened zone, canonical; ``zone`` is changed."""
    lower_at_most, past_lower, past_upper, kept = limits
    lower = zone[:n]
    whole = [INFINITY] * n
    past = [j for j in range(1, n) if lower[j] < past_upper[j]]
    loosened = [(0, j) for j in past if kept[j] > lower[j]]
    for _, j in loosened:
        zone[j] = kept[j]
    rows = [0]  # from which a bound leads on
    for i in range(1, n):
        at = i * n
        if lower[i] < past_lower[i]:
            zone[at : at + n] = whole
            zone[at + i] = AT_MOST_ZERO
            continue
        rows.append(i)
        most = lower_at_most[i]
        loose = [(at, j) for j, bound in enumerate(zone[at : at + n]) if most < bound != INFINITY]
        loose += [(at, j) for j in past if j != i and zone[at + j] <= most]
        for _, j in loose:
            zone[at + j] = INFINITY
        loosened += loose
    _close(zone, n, rows, loosened)
    return tuple(zone)


def _close(zone: list[int], n: int, rows: list[int], loosened: list[tuple[int, int]]) -> None:
    """Make canonical what was, but for the bounds that were loosened (start of their row, column), in place.

    Floyd and Warshall's way, over the loosened bounds only: the others are as tight as ever, and a row without bounds
    neither gets one nor leads to one.
    """
    for k in rows if loosened else ():
        on = zone[k * n : k * n + n]
        for at, column in loosened:
            to, then = zone[at + k], on[column]
            if to != INFINITY != then:
                over = to + then - ((to | then) & 1)
                if over < zone[at + column]:
                    zone[at + column] = over
