"""The clock that all processes of a machine share, and the tuning of the interpreter for short reaction times."""

from __future__ import annotations

import ctypes
import gc
import sys
import time
from contextlib import suppress


def now_us() -> int:
    """Return CLOCK_MONOTONIC in µs; all processes of one machine share this clock."""
    return time.monotonic_ns() // 1000


SWITCH_S = 0.0005
"""Time after which a computing thread yields to a waiting one, s; Python's default is ten times as long."""
COLLECT_AFTER = 10_000
"""Number of new objects before a garbage collection; objects of a reaction are freed without one, and cycles are rare.
"""


def tune_interpreter() -> None:
    """Tune Python for short reaction times; call this after all objects are built.

    The garbage collector no longer scans the existing objects, which would take milliseconds each time. Memory that
    was only needed to build them (the trees of two parsers) is returned to the system.
    """
    sys.setswitchinterval(SWITCH_S)
    gc.unfreeze()  # objects that a call before this one has frozen
    gc.collect()
    with suppress(OSError, AttributeError):  # only glibc has it
        ctypes.CDLL(None).malloc_trim(0)
    gc.freeze()
    gc.set_threshold(COLLECT_AFTER, 20, 20)
