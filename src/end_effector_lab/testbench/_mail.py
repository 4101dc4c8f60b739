"""From the threads of a testbench to its main thread."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from queue import SimpleQueue

from end_effector_hal.errors import ReportedError
from end_effector_hal.signals import Value

from ._records import Events, Record
from ._testbench import Watcher
from ._voice import Voice


class Mail(Watcher):
    """What is told in the threads is done in the main one: a slow terminal or disk holds up no frame.

    Args:
        voice: says each edge; None: it does not.
        events: written on each edge and frame.
        record: written on each frame.
    """

    def __init__(self, voice: Voice | None, events: Events | None, record: Record | None) -> None:
        self._voice, self._events, self._record = voice, events, record
        self._queue: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._read, self._wake = os.pipe()
        os.set_blocking(self._read, False)
        os.set_blocking(self._wake, False)
        self.ended = False
        self.error: ReportedError | None = None

    def fileno(self) -> int:
        """Can be read when there is something to deliver."""
        return self._read

    def line(self, name: str, level: bool, at: int, seen: int) -> None:
        """Say and write down an edge."""
        if events := self._events:
            self._post(lambda: events.line(name, level, at, seen))
        if voice := self._voice:
            text = f"{at / 1e6:.6f} {name} {'active' if level else 'inactive'}"
            self._post(lambda: voice.say(text, at=at, line=name, level=level))

    def frame(self, at: int, seq: int, values: Mapping[str, Value], sent: bool) -> None:
        """Write down a frame."""
        if events := self._events:
            self._post(lambda: events.frame(at, seq, values, sent))
        if record := self._record:
            self._post(lambda: record.frame(at, values))

    def failed(self, error: ReportedError) -> None:
        """End the program with this error."""
        self.error = error
        self.end()

    def end(self) -> None:
        """End the program; may be called in a signal handler."""
        self.ended = True
        self._ring()

    def deliver(self) -> None:
        """Do what has been posted, in its order."""
        with suppress(BlockingIOError):
            os.read(self._read, 4096)
        while not self._queue.empty():
            self._queue.get()()

    def close(self) -> None:
        """Give the pipe back; the threads have ended."""
        os.close(self._read)
        os.close(self._wake)

    def _post(self, task: Callable[[], None]) -> None:
        self._queue.put(task)
        self._ring()

    def _ring(self) -> None:
        with suppress(BlockingIOError):  # full: it is ringing already
            os.write(self._wake, b"x")
