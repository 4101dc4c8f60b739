"""ExtraLU+: a zone widened by what no guard can distinguish, so that there are finitely many zones.

Behrmann, Bouyer, Larsen, Pelánek, *Lower and Upper Bounds in Zone-Based Abstractions of Timed Automata*, 2006,
definition 4. With equal lower and upper limits it is ExtraM+.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from timed_automata.explore.zones._limits import NEVER, Limit
from timed_automata.explore.zones._zone import AT_MOST_ZERO, INFINITY, Zone, at_most, below, close


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
    before = tuple(zone)
    lower_at_most, past_lower, past_upper, kept = limits
    whole = [INFINITY] * n
    for i in range(1, n):
        at = i * n
        if before[i] < past_lower[i]:
            zone[at : at + n] = whole
        else:
            most = lower_at_most[i]
            zone[at : at + n] = [INFINITY if bound > most else bound for bound in zone[at : at + n]]
    for j in range(1, n):
        if before[j] < past_upper[j]:
            zone[n + j :: n] = whole[1:]
            zone[j] = max(kept[j], before[j])
        zone[j * n + j] = AT_MOST_ZERO
    after = tuple(zone)
    if after == before:
        return before
    close(zone, n)
    return tuple(zone)
