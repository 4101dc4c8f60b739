"""Input lines on which interlocks rest: the line arbiter reads them itself, and passes them on to the programs."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path

from end_effector_hal.description import Description
from end_effector_hal.errors import LineBusyError
from end_effector_hal.signals import Frame
from end_effector_hal.wires import RELAYED
from end_effector_hal.wires.inputs import InputsReader, inputs_record, lines_of
from end_effector_hal.wires.rpc import Server
from end_effector_hal.wires.sensors import FrameOrder

from ._predicate_publisher import PredicatePublisher

MOST_WAITING = 256
AGAIN_S = 0.1


class ArbiterInputs:
    """An `OwnInputs`: a thread reads the lines, another one passes on each frame; neither waits for the arbiter.

    Lines that another process has are tried again; until then they prove nothing.

    Args:
        description: the tool; it has `arbiter_inputs`.
        relay: path of the socket over which each frame is passed on.
        group: whose members may read there; default: that of the process.

    Raises:
        WireError: the relay cannot be made.
    """

    def __init__(self, description: Description, relay: Path, group: str | None = None) -> None:
        self._relay = Server(relay, RELAYED, group)
        self._proven: deque[tuple[Mapping[str, bool], int]] = deque(maxlen=MOST_WAITING)
        self._records: deque[bytes] = deque(maxlen=MOST_WAITING)
        self._news_read, self._news = os.pipe2(os.O_CLOEXEC | os.O_NONBLOCK)
        self._ended, self._busy = False, ""
        self._order = FrameOrder()
        self._publisher = PredicatePublisher(description, sender=self)
        mine, lines = description.with_inputs(description.arbiter_inputs), lines_of(description, "arbiter")
        self._reader = InputsReader(mine, self._came, lines=lines)
        self._started = False
        self._relay.start("own inputs", self._turn)
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
        """Take from the publisher what is proven; while the lines cannot be read, only what does not hold counts."""
        if failing := bool(self.error):
            predicates = {name: holds for name, holds in predicates.items() if not holds}
        if predicates:
            self._proven.append((predicates, at_us))
            with suppress(BlockingIOError):
                os.write(self._news, b"x")
        return not failing

    def close(self) -> None:
        """Give the lines back."""
        if self._ended:
            return
        self._ended = True
        self._relay.close()
        self._reader.close()
        self._publisher.close()

    def _came(self, frame: Frame) -> None:
        # an edge may have come before the levels that were read just before it
        self._publisher.frame(self._order.next(frame), self._hand_on)

    def _hand_on(self, frame: Frame) -> None:
        self._records.append(inputs_record(frame))
        self._relay.wake()

    def _turn(self) -> float | None:
        """Begin to read as soon as the lines are free, and pass on the frames that were read."""
        self._started = self._started or self._start()
        while self._records:
            self._relay.send(self._records.popleft())
        return None if self._started else AGAIN_S

    def _start(self) -> bool:
        """Whether the lines are read; another process may have them, and end."""
        try:
            self._reader.start(patience_s=0)
        except LineBusyError as error:
            self._busy = str(error)
            return False
        self._busy = ""
        return True
