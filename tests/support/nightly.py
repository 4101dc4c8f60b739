"""How much is tried: tens of examples in an ordinary run, thousands in that of the night (``make nightly``)."""

from __future__ import annotations

import os

from hypothesis import Phase

NIGHTLY = "EEHAL_NIGHTLY" in os.environ


def examples(ordinary: int, nightly: int) -> int:
    """For hypothesis; EXPLORER_EXAMPLES says another number."""
    return int(os.environ.get("EXPLORER_EXAMPLES", nightly if NIGHTLY else ordinary))


# a network that fails is small already, and shrinking it by thousands of others takes hours
PHASES = [phase for phase in Phase if not (phase is Phase.shrink and NIGHTLY)]
