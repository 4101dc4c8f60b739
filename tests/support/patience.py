"""How long the tests wait for what other threads and processes do: only what fails takes so long."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")
PATIENCE_S = 60.0
FIRST_STEP_S, LONGEST_STEP_S = 0.0005, 0.01
"""A thread of this process is ready within a millisecond, often thousands of times in a test; a process is not."""


def wait_until(what: str, ready: Callable[[], T], timeout_s: float = PATIENCE_S) -> T:
    """What ``ready`` returns, once it is true."""
    end, step_s = time.monotonic() + timeout_s, FIRST_STEP_S
    while not (found := ready()):
        assert time.monotonic() < end, f"not within {timeout_s:g} s: {what}"
        time.sleep(step_s)
        step_s = min(2 * step_s, LONGEST_STEP_S)
    return found
