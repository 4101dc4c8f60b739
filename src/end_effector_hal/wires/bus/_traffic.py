"""What goes over a bus that has outputs, sans-IO: reads in their cycle, and writes between two of them."""

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
MOST_KEPT = 512


class Cycle(NamedTuple):
    """One cycle of reads: when it was over, µs, the answers as they came, and the frame if there is one."""

    at: int
    answers: tuple[bytes, ...]
    frame: Frame | None


class EchoFilter:
    """Takes what an RS-485 adapter hears of itself out of what comes.

    The answer to a write of one register or coil repeats the request, so only other requests show whether it does. A
    glitch may precede an echo, or destroy one: it is looked for anywhere, and one that is missing proves little.
    """

    SAME_ANSWER = (5, 6)
    MOST_MISSED = 3

    def __init__(self) -> None:
        self.echoes = False
        """Whether the adapter hears itself: a read has shown it, and the last three have not all shown the contrary."""
        self._request, self._heard, self._passed, self._missed = b"", b"", True, 0

    def sent(self, request: bytes) -> None:
        """This is what comes first, if it does."""
        self._learn()
        self._request, self._heard, self._passed = request, b"", False

    def feed(self, data: bytes) -> bytes:
        """What has come without the echo; what may be the beginning of one waits."""
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
        """Whether the answer to this request is another than its echo."""
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
    """Asks and commands, one request at a time.

    Args:
        master: asks what the channels need.
        outputs: say what is to be written.
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
        """The last acknowledgement, until a read follows it."""
        self._echo = EchoFilter()
        self.unacknowledged = 0
        """Writes that were refused or not answered."""

    def poll(self, at: int) -> tuple[bytes, Cycle | None]:
        """What is to be sent now, and the cycle that ended because an answer did not come."""
        if self._write is not None:
            if at < self._until:
                return b"", None
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
        """The cycle that ends with what has come."""
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
            self._end_write(at, done=True)
        elif (start := self._rest.find(refused)) >= 0 and len(self._rest) - start >= EXCEPTION_BYTES:
            self._end_write(at, done=False, refusal=exception_words(self._rest[start + 2]))
        return None

    @property
    def due(self) -> int:
        """When `poll` is due."""
        if self._write is not None:
            return self._until
        due = self._master.due
        free_at = self._master.free_at
        if free_at is not None and not self._read_next and (wanted := self._outputs.due) is not None:
            due = min(due, max(wanted, free_at))
        return max(due, self._free_at)

    def _send(self, write: RegisterWrite, at: int) -> bytes:
        self._outputs.sent(write)
        self._write, self._rest, request = write, b"", write_request(write)
        self._until = at + self._master.answered_within_us(request)
        self._echo.sent(request)
        return request

    def _end_write(self, at: int, *, done: bool, refusal: str = "") -> None:
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
            self._outputs.failed(at, refusal)

    def _cycle(self, at: int, frames: tuple[Frame, ...], before: tuple[bytes, ...]) -> Cycle | None:
        if self._master.answers is before:
            return None
        frame = frames[-1] if frames else None
        if frame is not None:
            self._outputs.report(frame.values, frame.at, self._master.asked_at)
        return Cycle(at if frame is None else frame.at, self._master.answers, frame)
