"""Watch whether the ROS master still runs."""

from __future__ import annotations

import threading
from collections.abc import Callable

from end_effector_hal.errors import RosError

from ._calls import ask_pid

POLL_S = 1.5
MISSES = 2
"""Number of consecutive polls without an answer after which the master counts as gone (3 to 7 s)."""


class MasterWatch:
    """Reports once that the master is gone or was restarted, because a node does not register again by itself.

    Args:
        on_gone: called with a sentence, in the thread of the watch.
    """

    def __init__(self, on_gone: Callable[[str], None]) -> None:
        self._on_gone, self._pid = on_gone, ask_pid()
        self._end = threading.Event()
        threading.Thread(target=self._run, name="master watch", daemon=True).start()

    def close(self) -> None:
        """Stop the polls."""
        self._end.set()

    def _run(self) -> None:
        missed = 0
        while missed < MISSES and not self._end.wait(POLL_S):
            try:
                if ask_pid() != self._pid:
                    self._on_gone("The ROS master was started again; this node is not registered there.")
                    return
                missed = 0
            except RosError as error:
                missed += 1
                if missed == MISSES:
                    self._on_gone(str(error))
