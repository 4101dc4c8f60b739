"""A callback at a steady rate."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable


class Ticker:
    """Calls back every ``period_s`` in a thread of its own; what a callback raises is logged."""

    def __init__(self, period_s: float, callback: Callable[[], None], log: logging.Logger) -> None:
        self._period_s, self._callback, self._log = period_s, callback, log
        self._end = threading.Event()
        threading.Thread(target=self._run, name="ticker", daemon=True).start()

    def close(self) -> None:
        """No more ticks begin."""
        self._end.set()

    def _run(self) -> None:
        due = time.monotonic() + self._period_s
        while not self._end.wait(max(0.0, due - time.monotonic())):
            # after a pause of the machine ticks are left out, not made up for
            due = max(due + self._period_s, time.monotonic())
            try:
                self._callback()
            except Exception:  # noqa: BLE001 a callback may raise anything
                self._log.exception("a periodic task failed")
