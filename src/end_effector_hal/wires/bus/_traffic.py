"""The traffic on a bus with outputs, sans-IO: cyclic reads, and writes between two reads."""

from __future__ import annotations

from typing import NamedTuple

from end_effector_hal.codecs.modbus import (
    ModbusMaster,
    RegisterWrite,
    acknowledgement,
    exception_words,
    write_request,
)
from end_effector_hal.signals import Frame
from end_effector_hal.wires.bus._outputs import BusOutputs

EXCEPTION_BYTES = 5
NOT_NOW = (5, 6, 10, 11)
"""Exceptions of a device that is still at work or busy, and of a gateway that does not reach it."""
LATE_US = 1_000_000
"""Time after which the answer to a write no longer comes, µs."""
MOST_KEPT = 512


class Cycle(NamedTuple):
    """One cycle of reads.

    Attributes:
        at: the time of its end, µs.
        answers: the raw answers.
        frame: the frame, if there is one.
        inactive: the outputs that were known to be inactive when it began.
    """

    at: int
    answers: tuple[bytes, ...]
    frame: Frame | None
    inactive: tuple[str, ...]


class EchoFilter:
    """Removes from the received data the echo that some RS-485 adapters return of their own requests.

    The answer to a write of one register or coil equals its request, so only other requests show whether there is an
    echo. A glitch may precede an echo or destroy it: the echo is searched anywhere in the data, and one missing echo
    proves little.
    """

    SAME_ANSWER = (5, 6, 22)
    MOST_MISSED = 3

    def __init__(self) -> None:
        self.echoes = False
        """Whether the adapter returns an echo: a read has shown it, and not all of the last three have shown the
        contrary.
        """
        self._request, self._heard, self._passed, self._missed = b"", b"", True, 0

    def sent(self, request: bytes) -> None:
        """Record a request whose echo may come next."""
        self._learn()
        self._request, self._heard, self._passed = request, b"", False

    def feed(self, data: bytes) -> bytes:
        """Return the received data without the echo; data that may be the beginning of an echo is kept back."""
        self._heard = (self._heard + data)[-MOST_KEPT:]
        if self._passed:
            return data
        heard, request = self._heard, self._request
        if self._shows and heard.startswith(request):
            self.echoes = True
        if self.echoes:
            _, echo, rest = heard.partition(request)
            self._passed = bool(echo)
            return rest
        if len(heard) < len(request) and request.startswith(heard):
            return b""
        self._passed = True
        return heard

    @property
    def _shows(self) -> bool:
        """Whether the answer to this request differs from its echo."""
        return len(self._request) > 1 and self._request[1] not in self.SAME_ANSWER

    def _learn(self) -> None:
        if not self._shows or not self._heard:
            return
        if self._request in self._heard:
            self.echoes, self._missed = True, 0
            return
        self._missed += 1
        if self._missed >= self.MOST_MISSED:
            self.echoes = False


class BusTraffic:
    """Sends reads and writes, one request at a time.

    Args:
        master: makes the reads that the channels need.
        outputs: make the writes.
    """

    def __init__(self, master: ModbusMaster, outputs: BusOutputs) -> None:
        self._master, self._outputs = master, outputs
        self._write: RegisterWrite | None = None
        self._until = 0
        self._free_at = 0
        self._rest = b""
        # a read shows whether the adapter hears itself; and after a write that failed it comes first, or one dead
        # device would end the reading of the others
        self._read_next = True
        self._done = b""
        """The last acknowledgement, until the next read."""
        self._echo = EchoFilter()
        self._unheard: tuple[RegisterWrite, int] | None = (
            None  # the last write without an answer, and when it ended
        )
        self.unacknowledged = 0
        """Number of writes that were refused or not answered."""

    def poll(self, at: int) -> tuple[bytes, Cycle | None]:
        """Return the data to send now, and the cycle that ended because an answer is missing."""
        if self._write is not None:
            if at < self._until:
                return b"", None
            if not self._may_be_late(self._write, at):
                self._unheard = self._write, at
            self._end_write(at, done=False)
        free_at = self._master.free_at
        free = free_at is not None and at >= max(free_at, self._free_at)
        if free and not self._read_next and (write := self._outputs.next_write(at)) is not None:
            # an answer that comes twice would be taken for that to the next write, if they read the same
            self._read_next = acknowledgement(write) == self._done
            if not self._read_next:
                return self._send(write, at), None
        if at < self._free_at:
            return b"", None
        before = self._master.answers
        polled = self._master.poll(at)
        if polled.data:
            self._read_next, self._done = False, b""
            self._echo.sent(polled.data)
        return polled.data, self._cycle(at, polled.frames, before)

    def feed(self, data: bytes, at: int) -> Cycle | None:
        """Process received data; return the cycle that it completes, or None."""
        data = self._echo.feed(data)
        if not data:
            return None
        if self._write is None:
            before = self._master.answers
            return self._cycle(at, tuple(self._master.feed(data, at)), before)
        self._rest = (self._rest + data)[-MOST_KEPT:]
        done = acknowledgement(self._write)
        refused = bytes([self._write.unit, done[1] | 0x80])
        if done in self._rest:
            self._end_write(at, done=not self._may_be_late(self._write, at))
        elif (start := self._rest.find(refused)) >= 0 and len(self._rest) - start >= EXCEPTION_BYTES:
            self._end_write(at, done=False, exception=self._rest[start + 2])
        return None

    @property
    def due(self) -> int:
        """The time at which `poll` is due."""
        if self._write is not None:
            return self._until
        due = self._master.due
        free_at = self._master.free_at
        if free_at is not None and not self._read_next and (wanted := self._outputs.due) is not None:
            due = min(due, max(wanted, free_at))
        return max(due, self._free_at)

    def _may_be_late(self, write: RegisterWrite, at: int) -> bool:
        """Return whether an acknowledgement may be that of an earlier write of other values: it does not say which."""
        before, since = self._unheard or (write, at)
        return before != write and at - since < LATE_US and acknowledgement(before) == acknowledgement(write)

    def _send(self, write: RegisterWrite, at: int) -> bytes:
        self._outputs.sent(write)
        self._write, self._rest, request = write, b"", write_request(write)
        self._until = at + self._master.answered_within_us(request)
        self._echo.sent(request)
        return request

    def _end_write(self, at: int, *, done: bool, exception: int = 0) -> None:
        write, self._write, self._rest = self._write, None, b""
        self._free_at = at + self._master.silence_after_us
        if write is None:
            return
        if done:
            self._done = acknowledgement(write)
            self._outputs.acknowledged(at)
        else:
            self.unacknowledged += 1
            self._read_next = True
            refusal = exception_words(exception) if exception else ""
            self._outputs.failed(at, refusal, for_good=exception not in (0, *NOT_NOW))

    def _cycle(self, at: int, frames: tuple[Frame, ...], before: tuple[bytes, ...]) -> Cycle | None:
        if self._master.answers is before:
            return None
        self._outputs.heard(self._master.answered_units)
        frame = frames[-1] if frames else None
        if frame is not None:
            self._outputs.report(frame.values, frame.at, self._master.asked_at)
        end, inactive = at if frame is None else frame.at, self._outputs.inactive(self._master.asked_at, at)
        return Cycle(end, self._master.answers, frame, inactive)
