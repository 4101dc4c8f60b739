"""Calls into a codec, which may be somebody else's code: whatever one raises becomes a `CodecFailure`."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TypeVar

from end_effector_hal.errors import LinkError
from end_effector_hal.plugins import named
from end_effector_hal.wires._clock import now_us

T = TypeVar("T")
HUNG_US = 1_000_000
"""A call that takes longer than this has failed, and until it returns the link is down."""
TODO = "A new decoder is started; report this to the author of the codec."


class CodecFailure(LinkError):
    """The codec of a link raised an exception, or answered what no codec may."""


class CodecCalls:
    """Makes them, one at a time; nothing can be done about one that does not return but to say so.

    Args:
        where: the port, for sentences.
    """

    def __init__(self, where: str) -> None:
        self._where = where
        self.name = "the codec"
        self._busy: tuple[str, int] | None = None

    @property
    def hung(self) -> tuple[str, int] | None:
        """The call that has not returned for too long, in a sentence, and since when (µs); for any thread."""
        busy = self._busy
        if busy is None or (lasts := now_us() - busy[1]) < HUNG_US:
            return None
        what = f"{self.name} has not returned from {busy[0]} for {lasts // 1_000_000} s."
        todo = "Nothing is read until it does; report it to the author of the codec."
        return str(LinkError(what, where=self._where, todo=todo)), busy[1]

    def run(self, what: str, function: Callable[[], T]) -> T:
        """Call it; raises CodecFailure for whatever it raises, and when it took too long."""
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
        """The error for something that the codec did."""
        return CodecFailure(f"{self.name} failed: {what}.", where=self._where, todo=TODO)
