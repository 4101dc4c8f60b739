"""The one clock of all processes of a machine."""

from __future__ import annotations

import time


def now_us() -> int:
    """CLOCK_MONOTONIC in µs; the processes of one machine share it."""
    return time.monotonic_ns() // 1000
