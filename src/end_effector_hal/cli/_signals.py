"""Signals that end a command on its way out, as Ctrl-C does."""

from __future__ import annotations

import signal
import sys
from types import FrameType


def end_in_order() -> None:
    """Have SIGTERM and SIGHUP raise SystemExit in the main thread: what was begun is ended, nothing is left."""
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, _end)


def _end(number: int, _frame: FrameType | None) -> None:
    sys.exit(128 + number)
