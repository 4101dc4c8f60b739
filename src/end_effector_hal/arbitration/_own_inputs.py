"""Input lines on which interlocks rest: the line arbiter reads them itself, and hands them on to the programs."""

from __future__ import annotations

import logging
import os
import select
import socket
import threading
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path

from end_effector_hal.description import Description
from end_effector_hal.errors import LineBusyError
from end_effector_hal.signals import Frame
from end_effector_hal.wires import RelayServer
from end_effector_hal.wires.inputs import InputsReader, inputs_record, lines_of
from end_effector_hal.wires.sensors import FrameOrder

from ._predicate_publisher import PredicatePublisher

_log = logging.getLogger("end_effector_hal.arbiter")
MOST_WAITING = 256
AGAIN_S = 0.1
CLOSE_S = 2.0


class ArbiterInputs:
    """An `OwnInputs`: a thread reads the lines, another one hands each frame on; neither waits for the arbiter.

    Lines that cannot be had are tried again; what rests on them is not proven meanwhile.

    Args:
        description: the tool; it has `arbiter_inputs`.
        relay: path of the socket over which each frame is handed on.
        group: whose members may read there; default: that of the process.

    Raises:
        WireError: the relay cannot be made.
    """

    def __init__(self, description: Description, relay: Path, group: str | None = None) -> None:
        self._relay = RelayServer(relay, group)
        self._proven: deque[tuple[Mapping[str, bool], int]] = deque(maxlen=MOST_WAITING)
        self._records: deque[bytes] = deque(maxlen=MOST_WAITING)
        self._news_read, self._news = os.pipe2(os.O_CLOEXEC | os.O_NONBLOCK)
        self._wake_read, self._wake = os.pipe2(os.O_CLOEXEC | os.O_NONBLOCK)
        self._ended, self._busy = threading.Event(), ""
        self._order = FrameOrder()
        self._publisher = PredicatePublisher(description, sender=self)
        mine, lines = description.with_inputs(description.arbiter_inputs), lines_of(description, "arbiter")
        self._reader = InputsReader(mine, self._came, lines=lines)
        self._thread = threading.Thread(target=self._run, name="own inputs", daemon=True)
        self._thread.start()
        self._publisher.start()

    def fileno(self) -> int:
        """See `OwnInputs`."""
        return self._news_read

    def read(self) -> Iterator[tuple[Mapping[str, bool], int]]:
        """See `OwnInputs`."""
        with suppress(BlockingIOError):
            os.read(self._news_read, 4096)
        while self._proven:
            yield self._proven.popleft()

    @property
    def error(self) -> str:
        """See `OwnInputs`."""
        return self._busy or self._reader.health.error

    def send(self, predicates: Mapping[str, bool], at_us: int) -> bool:
        """What is proven, by the publisher; while the lines cannot be read, only what does not hold counts."""
        if failing := bool(self.error):
            predicates = {name: holds for name, holds in predicates.items() if not holds}
        if predicates:
            self._proven.append((predicates, at_us))
            _poke(self._news)
        return not failing

    def close(self) -> None:
        """Give the lines back."""
        if self._ended.is_set():
            return
        self._ended.set()
        _poke(self._wake)
        self._thread.join(CLOSE_S)
        self._reader.close()
        self._publisher.close()
        self._relay.close()

    def _came(self, frame: Frame) -> None:
        # an edge may have come before the levels that were read just before it
        self._publisher.frame(self._order.next(frame), self._hand_on)

    def _hand_on(self, frame: Frame) -> None:
        self._records.append(inputs_record(frame))
        _poke(self._wake)

    def _run(self) -> None:
        started = False
        while not self._ended.is_set():
            try:
                started = started or self._started()
                self._serve(None if started else AGAIN_S)
            except Exception as error:  # noqa: BLE001 this thread outlives a lack of files, or of memory
                _log.error("the inputs of the line arbiter cannot be handed on: %s", error)
                self._ended.wait(AGAIN_S)

    def _started(self) -> bool:
        """Whether the lines are read; somebody else may have them, and end."""
        try:
            self._reader.start(patience_s=0)
        except LineBusyError as error:
            self._busy = str(error)
            return False
        self._busy = ""
        return True

    def _serve(self, wait_s: float | None) -> None:
        relay = self._relay.sockets
        waited: list[int | socket.socket] = [self._wake_read, *relay]
        ready = select.select(waited, [], [], wait_s)[0]
        with suppress(BlockingIOError):
            os.read(self._wake_read, 4096)
        for each in relay:
            if each in ready and each in self._relay.sockets:
                self._relay.ready(each)
        while self._records:
            self._relay.send(self._records.popleft())


def _poke(end: int) -> None:
    with suppress(BlockingIOError):
        os.write(end, b"x")
