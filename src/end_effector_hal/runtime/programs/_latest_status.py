"""Keep the latest status of a program, wait for it, and pass it to a listener whose errors cannot end the program."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

from end_effector_hal.control import Status
from end_effector_hal.runtime._error_text import error_text

_log = logging.getLogger("end_effector_hal.runtime")
Listener = Callable[[Status], None]


class LatestStatus:
    """Holds the latest status of a program; thread-safe. Once ``ended`` is set, no other status follows.

    Args:
        status: the first status; the listener does not get it.
        listener: called with each status, in the thread that publishes it; it must not wait. An exception becomes
            :attr:`trouble`, and the listener is still called with the next status.
    """

    def __init__(self, status: Status, listener: Listener | None = None) -> None:
        self.status = status
        self.ended = False
        self.trouble = ""
        """A sentence about the exception of the listener's last call; empty: there was none."""
        self._listener = listener
        self._changed = threading.Condition()

    def publish(self, status: Status) -> None:
        """Replace the status, wake all waiting threads, and call the listener."""
        with self._changed:
            self.status = status
            self._changed.notify_all()
        if self._listener is None:
            return
        try:
            self._listener(status)
        except (Exception, SystemExit) as error:  # noqa: BLE001 it may raise anything
            what = f"A listener failed and missed a status: {error_text(error)}"
            if not self.trouble:
                _log.exception("%s", what)
            self.trouble = self.trouble or what
        else:
            self.trouble = ""

    def end(self) -> None:
        """Wake all waiting threads: no other status follows."""
        with self._changed:
            self.ended = True
            self._changed.notify_all()

    def wait(self, until: Callable[[Status], bool], timeout_s: float | None = None) -> bool:
        """Block until a status satisfies ``until``; return False on a time-out or when the program has ended."""
        with self._changed:
            self._changed.wait_for(lambda: self.ended or until(self.status), timeout_s)
            return until(self.status)
