"""Waiting for what other processes do."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")
TICK_S = 0.02
stopping = threading.Event()


class Late(Exception):
    """It did not happen in time."""


class Stopped(BaseException):
    """The whole program was told to end."""


def until(what: str, ready: Callable[[], T | None], timeout_s: float = 20.0) -> T:
    """What ``ready`` returns, once it is true; raises Late, Stopped."""
    end = time.monotonic() + timeout_s
    while not (found := ready()):
        if stopping.is_set():
            raise Stopped
        if time.monotonic() > end:
            raise Late(f"not within {timeout_s:g} s: {what}")
        time.sleep(TICK_S)
    return found


def pause(seconds: float) -> None:
    """Let time pass; raises Stopped."""
    if stopping.wait(seconds):
        raise Stopped
