"""The one clock of all processes of a machine, and an interpreter that does not come between."""

from __future__ import annotations

import ctypes
import gc
import sys
import time
from contextlib import suppress


def now_us() -> int:
    """CLOCK_MONOTONIC in µs; the processes of one machine share it."""
    return time.monotonic_ns() // 1000


SWITCH_S = 0.0005
"""A thread that computes gives way to one that has something to do after this; Python's own is ten times as long."""
COLLECT_AFTER = 10_000
"""Objects; what a reaction makes is freed without a collection, and cycles are rare."""


def tune_interpreter() -> None:
    """Tune Python for short reactions; call it when everything is built.

    The garbage collector no longer scans the objects that exist now, which would take milliseconds each time. Memory
    that was needed to build them (the trees of two parsers) is given back to the machine.
    """
    sys.setswitchinterval(SWITCH_S)
    gc.unfreeze()  # objects that a call before this one has frozen
    gc.collect()
    with suppress(OSError, AttributeError):  # only glibc has it
        ctypes.CDLL(None).malloc_trim(0)
    gc.freeze()
    gc.set_threshold(COLLECT_AFTER, 20, 20)
