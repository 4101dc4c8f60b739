"""The newest status of a program, and waiting for one."""

from __future__ import annotations

import threading
from collections.abc import Callable

from end_effector_hal.control import Status


class Newest:
    """Thread-safe; ``ended``: there will be no other."""

    def __init__(self, status: Status) -> None:
        self.status = status
        self.ended = False
        self._changed = threading.Condition()

    def tell(self, status: Status) -> None:
        """There is a newer one."""
        with self._changed:
            self.status = status
            self._changed.notify_all()

    def end(self) -> None:
        """Whoever waits, waits no more."""
        with self._changed:
            self.ended = True
            self._changed.notify_all()

    def wait(self, until: Callable[[Status], bool], timeout_s: float | None = None) -> bool:
        """Block until a status satisfies ``until``; False when the time is over or the program has ended."""
        with self._changed:
            self._changed.wait_for(lambda: self.ended or until(self.status), timeout_s)
            return until(self.status)
