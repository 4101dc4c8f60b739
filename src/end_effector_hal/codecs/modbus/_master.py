"""The master of a Modbus line, sans-IO."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from end_effector_hal.codecs._codec import Polled
from end_effector_hal.codecs.modbus import _adu as adu
from end_effector_hal.codecs.modbus._read import Read
from end_effector_hal.signals import Frame, Value

MIX_UP_US = 1_000_000
"""Time after which a missing answer is lost for good, µs."""
FAULT_US = 2_000_000
"""Time of correct answers after which an earlier fault is no longer reported, µs."""
EXCEPTIONS = {
    1: "illegal function", 2: "illegal data address", 3: "illegal data value", 4: "device failure", 6: "device busy",
    10: "gateway path unavailable", 11: "gateway target does not respond",
}  # fmt: skip
"""The standard's names of the exceptions."""


def exception_words(code: int) -> str:
    """Return an exception in words: ``exception 2, illegal data address``."""
    return f"exception {code}, {EXCEPTIONS.get(code, 'not of the standard')}"


STANDSTILL_US = 500_000
"""Delay of this process after which the age of a waiting answer is unknown, µs."""


class ReadCycle:
    """Makes a frame from the answers of one cycle, and counts; see `Decoder` for the counters.

    Args:
        reads: the reads of a cycle.
        baudrate: of the line; 0: there is none.
    """

    def __init__(self, reads: Sequence[Read], baudrate: int) -> None:
        self.bytes = 0
        self.frames = 0
        self.lost = 0
        self.reboots = 0
        self.errors: Counter[str] = Counter()
        self._reads, self._baudrate = reads, baudrate
        self._values: dict[str, Value] = {}
        self._faulty: dict[Read, tuple[int, str]] = {}

    @property
    def faults(self) -> tuple[str, ...]:
        """Present or recent faults of the answers: sentences."""
        return tuple([text for _, text in self._faulty.values()])

    def _unheard(self, read: Read, at: int) -> None:
        self.errors["timeout"] += 1
        wired = "Check its power, the wires A and B, unit, baud rate and parity."
        todo = (
            wired if self._baudrate else "Check its power and its unit; behind a gateway also the line there."
        )
        self._faulty[read] = at, f"{read.place}: no answer. {todo}"

    def _taken(self, read: Read, answer: bytes, at: int) -> dict[str, Value]:
        if answer[1] != read.function:
            self.errors["refused"] += 1
            todo = "Check the device and its sensor."
            if answer[2] <= 3:
                todo = (
                    "Does the device have these registers? Check register_type, address (from 0 on) and gap."
                )
            self._faulty[read] = at, f"{read.place}: refused with {exception_words(answer[2])}. {todo}"
            return {name: None for part in read.registers for name in part.channels}
        words = adu.words_of(read, answer)
        values = {name: value for part in read.registers for name, value in part.values(words).items()}
        if wrong := [part for part in read.registers if part.implausible(words)]:
            self.errors["range"] += len(wrong)
            names, shown = (
                ", ".join(name for part in wrong for name in part.channels),
                " ".join(map(hex, words)),
            )
            self._faulty[read] = (
                at,
                (
                    f"{read.place}: no sensor can send this value of {names} ({shown}). "
                    "Check value_type, word_order, byte_order, scale and range."
                ),
            )
        elif read in self._faulty and at - self._faulty[read][0] >= FAULT_US:
            del self._faulty[read]
        return values

    def _cycle_over(self, heard_at: int | None) -> tuple[Frame, ...]:
        """Return the frame of a cycle if a device has answered; ``heard_at``: time of the last answer, µs."""
        if heard_at is None:
            self.lost += 1
            return ()
        self.frames += 1
        values = {
            name: self._values.get(name)
            for read in self._reads
            for part in read.registers
            for name in part.channels
        }
        return (Frame(heard_at, None, None, values),)


class ModbusMaster(ReadCycle):
    """Sends the reads one after the other; keeps at most the bytes since the last request that could be its answer.

    Args:
        reads, baudrate, period_us, timeout_us, pause_us: see `ModbusRtu`.
    """

    BITS = 11
    """Most bits of a byte on the line: start, 8, parity, stop."""

    def __init__(
        self, reads: Sequence[Read], *, baudrate: int, period_us: int, timeout_us: int, pause_us: int = 0
    ) -> None:
        super().__init__(reads, baudrate)
        self.due = 0
        self.free_at: int | None = 0
        """Time from which on the line is free for other requests, µs; None: an answer is awaited."""
        self.answers: tuple[bytes, ...] = ()
        """The raw answers of the last complete cycle, b"" for a missing one; before that an empty tuple."""
        self.asked_at = 0
        """Time of the first request of the cycle, µs."""
        self._period_us, self._timeout_us = period_us, timeout_us
        self.silence_after_us = max(self.silence_us(baudrate), pause_us)
        """Pause on the line after an answer, µs."""
        self._next = 0
        self._unanswered: dict[tuple[int, int, int], tuple[Read, int]] = {}
        self._pending: Read | None = None
        self._heard: list[bytes] = []
        self._heard_at: int | None = None
        self._rest = b""

    @property
    def answered_units(self) -> frozenset[int]:
        """The units that answered a read of the last complete cycle, not with an exception."""
        pairs = zip(self._reads, self.answers, strict=False)
        return frozenset(read.unit for read, answer in pairs if answer[1:2] == bytes([read.function]))

    @classmethod
    def silence_us(cls, baudrate: int) -> int:
        """Return the silence that the standard requires between two frames, µs; none if there is no serial line."""
        return max(1_750, int(3.5 * cls.BITS) * 1_000_000 // baudrate) if baudrate else 0

    def poll(self, at: int) -> Polled:
        """Return the next request if it is due; a pending request without an answer counts as invalid."""
        if at < self.due:
            return Polled()
        frames: tuple[Frame, ...] = ()
        if self._pending is not None:
            self._unheard(self._pending, at)
            self._unanswered[self._pending.form] = self._pending, at
            frames = self._end(at)
            return Polled(b"", frames)  # the line is free: a write may come before the next read
        if self._next and at - self.due > STANDSTILL_US:
            self.errors["late"] += 1
            self._next = 0
        if self._next == 0:
            self.asked_at, self._values, self._heard_at = at, {}, None
            self._heard = [b""] * len(self._reads)
            while self._may_mix(self._reads[self._next], at):  # never all: not who has not answered
                self._next += 1
        self._pending, self._rest, self.free_at = self._reads[self._next], b"", None
        request = adu.request(self._pending)
        self.due = at + self.answered_within_us(request)
        return Polled(request, frames)

    def feed(self, data: bytes, at: int) -> list[Frame]:
        """Return the frame if its cycle ends with an answer in ``data``; bytes without a request are noise."""
        self.bytes += len(data)
        if self._pending is None:
            self.errors["noise"] += len(data)
            return []
        self._rest += data
        answer = self._answer(self._pending)
        if answer is None:
            return []
        if at - self.due > STANDSTILL_US:
            self.errors["late"] += 1
            return list(self._end(at))
        self._values |= self._taken(self._pending, answer, at)
        self._heard_at = at
        return list(self._end(at, answer))

    def answered_within_us(self, request: bytes) -> int:
        """Return the longest wait for the answer to a request, from the request's first byte on, µs."""
        sent_us = len(request) * self.BITS * 1_000_000 // self._baudrate if self._baudrate else 0
        return self._timeout_us + sent_us

    def _may_mix(self, read: Read, at: int) -> bool:
        """Return whether a late answer to another read may still arrive and be mistaken for the answer to this one."""
        other, since = self._unanswered.get(read.form, (read, 0))
        return other is not read and at - since < MIX_UP_US

    def _answer(self, read: Read) -> bytes | None:
        """Return the answer in the received bytes; bytes that cannot begin an answer are discarded."""
        good = bytes([read.unit, read.function, read.answer_bytes])
        bad = bytes([read.unit, read.function | 0x80])
        rest, start = self._rest, 0
        while start < len(rest):
            size = _size(rest[start : start + 3], good, bad)
            candidate = rest[start : start + size]
            if size and (len(candidate) < size or adu.is_whole(candidate)):
                break
            self.errors["crc" if size else "noise"] += 1
            start += 1
        self._rest = rest[start:]
        size = _size(self._rest[:3], good, bad)
        return self._rest[:size] if size and len(self._rest) >= size else None

    def _end(self, at: int, answer: bytes = b"") -> tuple[Frame, ...]:
        """End the pending read; return the frame if it was the last read of the cycle and a device has answered."""
        self._pending, self._rest = None, b""
        self._heard[self._next] = answer
        self._next += 1
        while self._next < len(self._reads) and self._may_mix(self._reads[self._next], at):
            self._next += 1
        self._next %= len(self._reads)
        self.due = self.free_at = at + self.silence_after_us
        if self._next:
            return ()
        self.due = max(self.due, self.asked_at + self._period_us)
        self.answers = tuple(self._heard)
        return self._cycle_over(self._heard_at)


def _size(head: bytes, good: bytes, bad: bytes) -> int:
    """Return the size of the answer that begins with these bytes; 0: no answer begins so."""
    if head and good.startswith(head):
        return len(good) + good[2] + 2
    return len(bad) + 3 if head and bad.startswith(head[:2]) else 0
