"""Callbacks of a process of nodes: once when all its nodes exist, or at a steady rate."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable

from end_effector_hal.wires import tune_interpreter


class Starters:
    """Calls back once all nodes exist and memory is cleaned up, which takes so long that readings would
    become stale.
    """

    def __init__(self) -> None:
        self._callbacks: list[Callable[[], None]] = []

    def add(self, callback: Callable[[], None]) -> None:
        """Register a callback; they are called in the order of registration."""
        self._callbacks.append(callback)

    def start(self) -> None:
        """Tune the interpreter and call all callbacks: all nodes exist now."""
        tune_interpreter()
        for callback in self._callbacks:
            callback()


class Ticker:
    """Calls back every ``period_s`` in a thread of its own; an exception of the callback is logged."""

    def __init__(self, period_s: float, callback: Callable[[], None], log: logging.Logger) -> None:
        self._period_s, self._callback, self._log = period_s, callback, log
        self._end = threading.Event()
        threading.Thread(target=self._run, name="ticker", daemon=True).start()

    def close(self) -> None:
        """Stop: no more calls begin."""
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
