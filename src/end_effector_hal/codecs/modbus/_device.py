"""The answering end of a Modbus line: all devices of a codec, simulated."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from end_effector_hal.codecs.modbus import _adu as adu
from end_effector_hal.codecs.modbus._read import Read
from end_effector_hal.signals import Value


class ModbusDevice:
    """Answers the requests for these reads and no others; keeps at most one unfinished request."""

    def __init__(self, reads: Iterable[Read]) -> None:
        self._reads = {adu.request(read): read for read in reads}
        self._rest = b""

    def answer(self, data: bytes, values: Mapping[str, Value]) -> bytes:
        """The answers to the requests that end in ``data``; see `Device.answer`."""
        answers = b""
        self._rest += data
        while len(self._rest) >= adu.REQUEST_BYTES:
            read = self._reads.get(self._rest[: adu.REQUEST_BYTES])
            if read is not None:
                answers += self.answer_to(read, values)
            self._rest = self._rest[1 if read is None else adu.REQUEST_BYTES :]
        return answers

    def answer_to(self, read: Read, values: Mapping[str, Value]) -> bytes:
        """The answer to one read; an exception if one of its channels has no value."""
        words = [0] * read.count
        for register in read.registers:
            value = values.get(register.channel)
            if value is None:
                return adu.refusal(read)
            words[register.word] |= register.word_of(value)
        return adu.answer(read, words)
