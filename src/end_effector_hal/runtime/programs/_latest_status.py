"""The latest status of a program: kept, waited for, and passed to a listener that cannot end the program."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

from end_effector_hal.control import Status
from end_effector_hal.runtime._error_text import error_text

_log = logging.getLogger("end_effector_hal.runtime")
Listener = Callable[[Status], None]


class LatestStatus:
    """Thread-safe; ``ended``: there will be no other.

    Args:
        status: the first one; the listener does not get it.
        listener: called with each status, in the thread that publishes it; it must not wait. It may raise anything:
            that becomes :attr:`trouble`, and it is called with the next one all the same.
    """

    def __init__(self, status: Status, listener: Listener | None = None) -> None:
        self.status = status
        self.ended = False
        self.trouble = ""
        """What the listener raised at its last call, a sentence; empty: nothing."""
        self._listener = listener
        self._changed = threading.Condition()

    def publish(self, status: Status) -> None:
        """Replace the status, wake all who wait, and call the listener."""
        with self._changed:
            self.status = status
            self._changed.notify_all()
        if self._listener is None:
            return
        try:
            self._listener(status)
        except (Exception, SystemExit) as error:  # noqa: BLE001 it may raise anything
            what = f"A listener failed, and lacks a state: {error_text(error)}"
            if not self.trouble:
                _log.exception("%s", what)
            self.trouble = self.trouble or what
        else:
            self.trouble = ""

    def end(self) -> None:
        """End all waiting: no other status will come."""
        with self._changed:
            self.ended = True
            self._changed.notify_all()

    def wait(self, until: Callable[[Status], bool], timeout_s: float | None = None) -> bool:
        """Block until a status satisfies ``until``; False when the time is over or the program has ended."""
        with self._changed:
            self._changed.wait_for(lambda: self.ended or until(self.status), timeout_s)
            return until(self.status)
