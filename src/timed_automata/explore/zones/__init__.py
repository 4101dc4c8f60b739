"""Sets of clock valuations as difference bound matrices, and the limits up to which they are exact."""

from ._extrapolation import extrapolated, widening
from ._limits import Limit, Limits
from ._zone import (
    AT_MOST_ZERO,
    INFINITY,
    Zone,
    as_constraints,
    constrained,
    constraints_of,
    included,
    subtract,
    up,
)
