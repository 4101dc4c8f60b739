"""The end of a process of nodes: once, because the work is done, or with an error."""

from __future__ import annotations

import faulthandler
import os
import threading
import time
from contextlib import suppress
from queue import Empty, SimpleQueue

from end_effector_hal.errors import ReportedError

LOOK_S = 0.5
STDERR = 2
LONGEST_S = 20.0
"""What has not ended by then, whatever the reason of the end, is left by force and says where it hangs."""


class ProcessEnd:
    """Thread-safe, and safe in a signal handler.

    Args:
        longest_s: what ends in good order takes less; after an error the process is left by force then.
    """

    def __init__(self, longest_s: float) -> None:
        self._longest_s = longest_s
        self._failed: ReportedError | None = None
        self._begun = self._bounded = False
        # no Event: its lock may be held by the very thread in which a signal handler runs
        self._wake: SimpleQueue[None] = SimpleQueue()

    @property
    def begun(self) -> bool:
        """Whether the process shall end."""
        return self._begun

    @property
    def exit_code(self) -> int:
        """Of the process, as it is known now."""
        return self._failed.exit_code if self._failed else 0

    def begin(self) -> None:
        """The process shall end; once more does no harm."""
        self.bound()
        self._begun = True
        self._wake.put(None)

    def fail(self, error: ReportedError) -> bool:
        """End with an error, so that the launcher starts this process again; False: it has failed already."""
        if self._failed is not None:
            return False
        self._failed = error
        with suppress(RuntimeError):  # no thread
            threading.Thread(target=self._leave_by_force, args=(error,), daemon=True).start()
        return True

    def wait(self) -> int:
        """Wait for the end, in one thread; the exit code. Raises what :meth:`fail` was given."""
        while not self._begun:
            with suppress(Empty):  # a signal may reach another thread: its handler runs when this one looks
                self._wake.get(timeout=LOOK_S)
        if self._failed is not None:
            raise self._failed
        return 0

    def bound(self) -> None:
        """From now on the process has `LONGEST_S` to end; then it is left by force, and says where it hangs."""
        if not self._bounded:
            self._bounded = True
            # no thread of Python: what hangs may hold its lock, or be its end
            faulthandler.dump_traceback_later(LONGEST_S, exit=True, file=STDERR)

    def _leave_by_force(self, error: ReportedError) -> None:
        time.sleep(self._longest_s)
        os._exit(error.exit_code)
