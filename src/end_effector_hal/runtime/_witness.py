"""Whoever reads the sensor link tells the line arbiter what it proves."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping

from end_effector_hal.arbiter import PredicateSender
from end_effector_hal.codecs import Codec, get_codec
from end_effector_hal.description import Description, socket_path
from end_effector_hal.sensing import Predicates
from end_effector_hal.signals import Frame
from end_effector_hal.wires import now_us

from ._lines import arbiter_policy

REPEAT_US = 50_000
"""The owner hears it at least so often; it forgets it after 150 ms."""


class Witness:
    """Frames in, predicates to the line arbiter: on change at once, else every 50 ms.

    Call `frame` before the frame goes to anybody else: then the owner knows of it before any command that
    follows from it. A link that is slower than that is repeated by a thread, for as long as its readings are fresh.

    Args:
        description: the tool; its owner need not run yet.
        codec: of its link; default: the one that it names.
        clock: µs.
    """

    def __init__(
        self, description: Description, codec: Codec | None = None, clock: Callable[[], int] = now_us
    ) -> None:
        codec = codec or get_codec(description.link.codec)
        self._sender = PredicateSender(socket_path(description))
        self._predicates = Predicates(description, codec)
        needs = arbiter_policy(description).needs.values()
        self._needed = {need.predicate for needed in needs for need in needed}
        self._repeats = bool(self._needed) and codec.period_us > REPEAT_US // 2
        self._clock = clock
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._said: Mapping[str, bool] = {}
        self._due = 0
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Begin."""
        if self._repeats:
            self._thread = threading.Thread(target=self._repeat, name="witness", daemon=True)
            self._thread.start()

    def frame(self, frame: Frame) -> None:
        """One frame of the link; never blocks."""
        if self._needed:
            with self._lock:
                if said := self._predicates.frame(frame, self._clock()):
                    self._tell(said, frame.at)

    def close(self) -> None:
        """Say nothing any more."""
        self._ended.set()
        if self._thread:
            self._thread.join()
        with self._lock:
            self._sender.close()

    def _repeat(self) -> None:
        while not self._ended.wait(REPEAT_US / 1e6):
            with self._lock:
                at = self._clock()
                self._tell(self._predicates.advance(at), at)

    def _tell(self, proven: Mapping[str, bool], at: int) -> None:
        said = {name: holds for name, holds in proven.items() if name in self._needed}
        if (said != self._said or at >= self._due) and self._sender.send(said, at):
            self._said, self._due = said, at + REPEAT_US * 4 // 5
