"""The end of a process of nodes: once, because the work is done, or with an error."""

from __future__ import annotations

import os
import threading
import time

from end_effector_hal.errors import ReportedError

LOOK_S = 0.5


class ProcessEnd:
    """Thread-safe; ``begun`` is set when the process shall end.

    Args:
        longest_s: what ends in good order takes less; after an error the process is left by force then.
    """

    def __init__(self, longest_s: float) -> None:
        self._longest_s = longest_s
        self._failed: ReportedError | None = None
        self.begun = threading.Event()

    def fail(self, error: ReportedError) -> bool:
        """End with an error, so that the launcher starts this process again; False: it has failed already."""
        if self._failed is not None:
            return False
        self._failed = error
        threading.Thread(target=self._leave_by_force, args=(error,), daemon=True).start()
        return True

    def wait(self) -> int:
        """Wait for the end; the exit code. Raises what :meth:`fail` was given."""
        while not self.begun.wait(LOOK_S):
            pass  # the kernel may give a signal to another thread: its handler runs when this one looks
        if self._failed is not None:
            raise self._failed
        return 0

    def _leave_by_force(self, error: ReportedError) -> None:
        # without its master, or with a thread that hangs, ROS may not come to its end
        time.sleep(self._longest_s)
        os._exit(error.exit_code)
