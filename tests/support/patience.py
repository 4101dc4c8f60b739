"""How long the tests wait for what other threads and processes do: only what fails takes so long."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")
PATIENCE_S = 60.0


def wait_until(what: str, ready: Callable[[], T], timeout_s: float = PATIENCE_S) -> T:
    """What ``ready`` returns, once it is true."""
    end = time.monotonic() + timeout_s
    while not (found := ready()):
        assert time.monotonic() < end, f"not within {timeout_s:g} s: {what}"
        time.sleep(0.01)
    return found
