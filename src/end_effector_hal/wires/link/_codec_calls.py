"""Calls into a codec, which may be third-party code: any exception becomes a `CodecFailure`."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TypeVar

from end_effector_hal.errors import LinkError
from end_effector_hal.plugins import named
from end_effector_hal.wires._clock import now_us

T = TypeVar("T")
HUNG_US = 1_000_000
"""Longest time of a call, µs. A longer call has failed; until it returns, the link is down."""
TODO = "A new decoder is started; report this to the author of the codec."


class CodecFailure(LinkError):
    """The codec of a link raised an exception or returned a result that is not allowed."""


class CodecCalls:
    """Makes calls into a codec, one at a time. A call that does not return cannot be ended, only reported.

    Args:
        where: the port, for messages.
    """

    def __init__(self, where: str) -> None:
        self._where = where
        self.name = "the codec"
        self._busy: tuple[str, int] | None = None

    @property
    def hung(self) -> tuple[str, int] | None:
        """A sentence about a call that has not returned for too long, and its start, µs; readable from any thread."""
        busy = self._busy
        if busy is None or (lasts := now_us() - busy[1]) < HUNG_US:
            return None
        what = f"{self.name} has not returned from {busy[0]} for {lasts // 1_000_000} s."
        todo = "Nothing is read until it does; report it to the author of the codec."
        return str(LinkError(what, where=self._where, todo=todo)), busy[1]

    def run(self, what: str, function: Callable[[], T]) -> T:
        """Call the function; raises CodecFailure for any exception, and if the call took too long."""
        self._busy = (what, begun := now_us())
        try:
            result = function()
        except BaseException as error:  # SystemExit as well: it would end a thread in silence
            if isinstance(error, KeyboardInterrupt) and threading.current_thread() is threading.main_thread():
                raise
            raise self.failure(f"{what} raised {named(error)}") from error
        finally:
            self._busy = None
        if (took := now_us() - begun) >= HUNG_US:
            raise self.failure(f"{what} took {took / 1e6:.1f} s")
        return result

    def failure(self, what: str) -> CodecFailure:
        """Return the error for a failure of the codec."""
        return CodecFailure(f"{self.name} failed: {what}.", where=self._where, todo=TODO)
