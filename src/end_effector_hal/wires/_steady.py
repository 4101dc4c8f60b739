"""A program that reacts within a millisecond must not be stopped by its own interpreter."""

from __future__ import annotations

import gc
import sys

SWITCH_S = 0.0005
"""A thread that computes gives way to one that has something to do after this; Python's own is ten times as long."""
COLLECT_AFTER = 10_000
"""Objects; what a reaction makes is freed without a collection, and cycles are rare."""


def be_steady() -> None:
    """Call it once all is made: the collector never looks again at what is there now, which takes it ms each time."""
    sys.setswitchinterval(SWITCH_S)
    gc.collect()
    gc.freeze()
    gc.set_threshold(COLLECT_AFTER, 20, 20)
