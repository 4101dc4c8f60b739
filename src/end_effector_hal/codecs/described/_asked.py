"""Lines that a device sends only when it is asked: a request in each period, and the line that answers it."""

from __future__ import annotations

import builtins
from collections.abc import Mapping

from end_effector_hal.codecs._codec import Polled
from end_effector_hal.codecs.described._codec import DescribedCodec, SerialLine
from end_effector_hal.codecs.described._text import DescribedLines, LineDecoder
from end_effector_hal.signals import Frame, Value

PERIOD_US, PATIENCE_US = 100_000, 500_000
"""Time between two requests if the link gives no period, and the least wait for an answer, µs."""
TAIL_US = 10_000
"""Bytes without the end of a line, so shortly before a request, come from a device that sends by itself: the end of
that line follows. A prompt is older.
"""


class AskedLines(DescribedCodec):
    """The polled codec of lines that answer one request.

    Args:
        lines: the codec of the lines.
        ask: the request.
        line: settings of the link.
    """

    PERIOD_US = PERIOD_US

    def __init__(self, lines: DescribedLines, ask: str, line: SerialLine) -> None:
        self._lines, self.ask = lines, ask.encode()
        channels = {name: each for field in lines.fields for name, each in field.channels.items()}
        asking_us = line.wire_us(len(self.ask))
        super().__init__(channels, line, lines.least_period_us + asking_us)

    def decoder(self) -> AskingDecoder:
        """Return a new polled decoder."""
        return AskingDecoder(self._lines.decoder(), self.ask, self.period_us)

    def device(self) -> AnsweringDevice:
        """Return a new simulated device."""
        return AnsweringDevice(self._lines, self.ask)

    def encode(self, frame: Frame) -> bytes:
        """Return the answer to one request."""
        return self._lines.encode(frame)


class AskingDecoder:
    """Sends the request in each period, and takes the first line that can be read as its answer.

    Other lines after a request, such as its echo, are passed over. A request that is not answered in time is followed
    by a period without a request, in which a late answer is discarded: it is never taken for the answer to the next
    one.

    Args:
        lines: decodes the lines.
        ask: the request.
        period_us: time between two requests.
    """

    reboots = 0

    def __init__(self, lines: LineDecoder, ask: bytes, period_us: int) -> None:
        self._lines, self._ask, self._period_us = lines, ask, period_us
        self.bytes = self.frames = self.lost = 0
        self.due = 0
        self.faults: tuple[str, ...] = ()
        """The missing answer, a sentence, until there is one."""
        self._asked_at: int | None = None
        self._tail_until = 0

    @property
    def errors(self) -> Mapping[str, int]:
        """Counts of discarded data, by reason."""
        return self._lines.errors

    def poll(self, at: int) -> Polled:
        """Return the request if it is due."""
        if at < self.due:
            return Polled()
        if self._asked_at is not None:
            self._asked_at, self.due = None, at + self._period_us
            self.lost += 1
            self._lines.errors["timeout"] += 1
            self.faults = (
                f"no answer to {self._ask.decode()!r}. Check ask, its line end, the baud rate and the wires.",
            )
            return Polled()
        self._lines.begin(in_step=at >= self._tail_until)
        self._asked_at = at
        self.due = at + max(self._period_us, PATIENCE_US)
        return Polled(self._ask)

    def feed(self, data: builtins.bytes, at: int) -> list[Frame]:
        """Return the frame of the answer if it ends in ``data``."""
        self.bytes += len(data)
        self._tail_until = at if data.endswith(b"\n") else at + TAIL_US
        if self._asked_at is None:
            self._lines.errors["noise"] += len(data)
            return []
        frames = self._lines.feed(data, at)[:1]
        if frames:
            self.due = max(self._asked_at + self._period_us, at)
            self._asked_at, self.faults = None, ()
            self.frames += 1
        return frames


class AnsweringDevice:
    """A simulated device that answers each request with a line; keeps less than one request.

    Args:
        lines: the codec of the lines.
        ask: the request.
    """

    def __init__(self, lines: DescribedLines, ask: bytes) -> None:
        self._lines, self._ask, self._rest = lines, ask, b""

    def answer(self, data: bytes, values: Mapping[str, Value]) -> bytes:
        """Return the answers to the requests that end in ``data``; see `Device.answer`."""
        *requests, rest = (self._rest + data).split(self._ask)
        self._rest = rest[-(len(self._ask) - 1) :] if len(self._ask) > 1 else b""
        return b"".join(self._lines.encode(Frame(0, None, None, values)) for _ in requests)
