"""Sets of clock valuations as difference bound matrices, and the limits up to which they are exact."""

from ._extrapolation import Widening, extrapolated, widening
from ._limits import NEVER, Limit, Limits, QueryLimits, largest, limits_of, merged, tested_clocks
from ._zone import (
    AT_MOST_ZERO,
    IMPOSSIBLE,
    INFINITY,
    LARGEST,
    Constraint,
    UniqueZones,
    Zone,
    as_constraints,
    at_most,
    below,
    constrained,
    constraints_of,
    delay,
    down,
    everything,
    guard_bits,
    included,
    intersection,
    packed,
    subtract,
    tighten,
    unbounded,
    up,
)
