"""Decodes the answers of a bus whose master is another process, which relays each cycle unchanged."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Protocol

from end_effector_hal.codecs._codec import Codec, parity_of, resolution_of
from end_effector_hal.codecs.modbus import _adu as adu
from end_effector_hal.codecs.modbus._master import ReadCycle
from end_effector_hal.codecs.modbus._read import Read
from end_effector_hal.signals import Frame, Kind

LONGEST_ADU = 256


class BusCodec(Codec, Protocol):
    """A codec made of Modbus reads, see `ModbusRtu`."""

    @property
    def reads(self) -> Sequence[Read]:
        """The requests of one cycle, in their order."""
        ...


def cycle_record(answers: Sequence[bytes], at: int, inactive: Sequence[str] = ()) -> bytes:
    """Return one cycle as a line.

    Args:
        answers: the answer to each read, b"" if there was none.
        at: the end of the cycle, µs.
        inactive: the outputs that were known to be inactive when the cycle began.
    """
    record = {"at": at, "answers": [answer.hex() for answer in answers], "inactive": list(inactive)}
    return json.dumps(record, separators=(",", ":")).encode() + b"\n"


class RelayedBus:
    """The codec of a bus whose cycles arrive over the relay of the bus master.

    Args:
        bus: the codec that the bus master uses.
        outputs: the outputs of the bus.
    """

    def __init__(self, bus: BusCodec, outputs: Collection[str] = ()) -> None:
        self._bus, self._outputs = bus, frozenset(outputs)
        self.name, self.baudrate, self.parity = bus.name, bus.baudrate, parity_of(bus)
        self.channels: Mapping[str, Kind] = bus.channels
        self.period_us, self.resolution_pa = bus.period_us, resolution_of(bus)

    def decoder(self) -> RelayDecoder:
        """Return a new decoder, which sends no requests."""
        return RelayDecoder(self._bus.reads, self.baudrate, self._outputs)

    def encode(self, frame: Frame) -> bytes:
        """Return the record of a cycle whose answers make this frame."""
        answers, data = [], self._bus.encode(frame)
        for read in self._bus.reads:
            size = 3 + read.answer_bytes + 2 if data[1:2] == bytes([read.function]) else 5
            answers.append(data[:size])
            data = data[size:]
        return cycle_record(answers, frame.at)


class RelayDecoder(ReadCycle):
    """Decodes records. Damaged records, records of another bus, and unfinished data longer than a record are noise."""

    def __init__(self, reads: Sequence[Read], baudrate: int, outputs: frozenset[str] = frozenset()) -> None:
        super().__init__(reads, baudrate)
        self._outputs = outputs
        self._rest = b""
        self._last = 0
        # an answer as two digits a byte, in quotes; time and names
        self._longest = (
            (2 * LONGEST_ADU + 3) * len(reads) + sum(len(json.dumps(name)) + 1 for name in outputs) + 100
        )

    def feed(self, data: bytes, at: int) -> list[Frame]:
        """Return the frames of the records that end in ``data``, stamped with the time in each record."""
        self.bytes += len(data)
        *records, self._rest = (self._rest + data).split(b"\n")
        if len(self._rest) > self._longest:
            self.errors["noise"] += len(self._rest)
            self._rest = b""
        return [frame for record in records for frame in self._frames(record, at)]

    def _frames(self, record: bytes, at: int) -> Iterator[Frame]:
        cycle = _read(record, len(self._reads))
        if cycle is None or not self._last < cycle[0] <= at or not self._fits(cycle[1]):
            self.errors["noise"] += len(record)
            return
        self._last, answers, inactive = cycle
        self._values = {}
        for read, answer in zip(self._reads, answers, strict=True):
            if answer:
                self._values |= self._taken(read, answer, self._last)
            else:
                self._unheard(read, self._last)
        named = tuple(sorted(self._outputs.intersection(inactive)))
        for frame in self._cycle_over(self._last if any(answers) else None):
            yield replace(frame, inactive=named)

    def _fits(self, answers: Sequence[bytes]) -> bool:
        """Return whether each answer is empty or a valid answer to its read."""
        return all(
            not answer or (adu.is_whole(answer) and (_is_answer(answer, read) or _is_refusal(answer, read)))
            for read, answer in zip(self._reads, answers, strict=True)
        )


def _is_answer(adu_: bytes, read: Read) -> bool:
    head = bytes([read.unit, read.function, read.answer_bytes])
    return adu_.startswith(head) and len(adu_) == len(head) + read.answer_bytes + 2


def _is_refusal(adu_: bytes, read: Read) -> bool:
    return adu_.startswith(bytes([read.unit, read.function | 0x80])) and len(adu_) == 5


def _read(record: bytes, reads: int) -> tuple[int, list[bytes], list[str]] | None:
    """Return time, answers and inactive outputs of a record; None: it is not a record of this number of reads."""
    try:
        given = json.loads(record)
        at, answers = given["at"], [bytes.fromhex(each) for each in given["answers"]]
        inactive = [str(each) for each in given["inactive"]]
    except (ValueError, TypeError, KeyError, RecursionError):
        return None
    return (at, answers, inactive) if type(at) is int and len(answers) == reads else None
