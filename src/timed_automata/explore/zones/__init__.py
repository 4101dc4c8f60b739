"""Sets of clock valuations as difference bound matrices, and the limits up to which they are exact."""

from ._bound import AT_MOST_ZERO, INFINITY, LARGEST, at_most, below
from ._constraints import as_constraints
from ._extrapolation import Widening, extrapolated, widening
from ._limits import NEVER, Limit, Limits, largest, limits_of, merged
from ._located_limits import LocatedLimits, QueryLimits, tested_clocks
from ._zone import (
    Constraint,
    Unique,
    Zone,
    constrained,
    constraints_of,
    down,
    everything,
    included,
    intersection,
    subtract,
    tighten,
    unbounded,
    up,
)

__all__ = [
    "AT_MOST_ZERO",
    "INFINITY",
    "LARGEST",
    "NEVER",
    "Constraint",
    "Limit",
    "Limits",
    "LocatedLimits",
    "QueryLimits",
    "Unique",
    "Widening",
    "Zone",
    "as_constraints",
    "at_most",
    "below",
    "constrained",
    "constraints_of",
    "down",
    "everything",
    "extrapolated",
    "included",
    "intersection",
    "largest",
    "limits_of",
    "merged",
    "subtract",
    "tested_clocks",
    "tighten",
    "unbounded",
    "up",
    "widening",
]
