"""``modbus-rtu``: sensors that are polled one after the other, over RS-485; and devices with known registers.

The devices are only read: their actuators are switched by the lines.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from end_effector_hal.codecs.modbus import _adu as adu
from end_effector_hal.codecs.modbus._master import ModbusMaster
from end_effector_hal.codecs.modbus._read import INPUT, Read, Register
from end_effector_hal.errors import UsageError
from end_effector_hal.signals import Frame, Kind, Value


class ModbusDevice:
    """A simulated device that answers the requests for these reads only; keeps at most one unfinished request."""

    def __init__(self, reads: Iterable[Read]) -> None:
        self._reads = {adu.request(read): read for read in reads}
        self._rest = b""

    def answer(self, data: bytes, values: Mapping[str, Value]) -> bytes:
        """Return the answers to the requests that end in ``data``; see `Device.answer`."""
        answers = b""
        self._rest += data
        while len(self._rest) >= adu.REQUEST_BYTES:
            read = self._reads.get(self._rest[: adu.REQUEST_BYTES])
            if read is not None:
                answers += self.answer_to(read, values)
            self._rest = self._rest[1 if read is None else adu.REQUEST_BYTES :]
        return answers

    def answer_to(self, read: Read, values: Mapping[str, Value]) -> bytes:
        """Return the answer to one read; an exception if one of its channels has no value."""
        words = [0] * read.count
        if not all(register.put(words, values) for register in read.registers):
            return adu.refusal(read)
        return adu.answer(read, words)


class ModbusRtu:
    """A polled codec: a frame contains the results of one cycle of reads; channels of a device that did not answer are
    invalid.

    A tool with other devices needs only a list of reads: an instance of this class, or a subclass without arguments,
    behind an entry point.

    Args:
        name: the codec's name in a description.
        reads: the reads in the order of their requests.
        period_us: time from the start of a cycle to the start of the next one; a slow device makes it longer.
        baudrate, parity: settings of the line; parity ``N``, ``E`` or ``O``; baud rate 0: there is none.
        timeout_us: longest wait for an answer.
        pause_us: least time between an answer, or its time-out, and the next request.
        alike: whether answers to two reads of one unit may have the same form. If so, a read without an answer blocks
            the other reads of that form for one second.

    Raises:
        UsageError: two reads have the same channel, or a late answer to one read could be mistaken for an answer to
            another.
    """

    def __init__(
        self,
        name: str,
        reads: Sequence[Read],
        *,
        baudrate: int,
        period_us: int,
        parity: str = "N",
        timeout_us: int = 30_000,
        pause_us: int = 0,
        alike: bool = False,
    ) -> None:
        self.name, self.reads = name, tuple(reads)
        self.baudrate, self.parity = baudrate, parity
        self.period_us, self.timeout_us, self.pause_us = period_us, timeout_us, pause_us
        parts = [part for read in self.reads for part in read.registers]
        self.resolution_pa = max(part.step_pa for part in parts)
        names = [name for part in parts for name in part.channels]
        self.channels: Mapping[str, Kind] = {
            name: kind for part in parts for name, kind in part.channels.items()
        }
        if len(self.channels) < len(names):
            raise UsageError(f"{name} reads a channel twice: {', '.join(names)}.", todo="Name each once.")
        if not alike and len({read.form for read in self.reads}) < len(self.reads):
            raise UsageError(
                f"{name}: two reads of one unit have answers of the same form.",
                todo="Read their registers with one request, or a different number of registers.",
            )

    def decoder(self) -> ModbusMaster:
        """Return a new polled decoder."""
        return ModbusMaster(
            self.reads,
            baudrate=self.baudrate,
            period_us=self.period_us,
            timeout_us=self.timeout_us,
            pause_us=self.pause_us,
        )

    def device(self) -> ModbusDevice:
        """Return one simulated device that answers for all devices of the bus."""
        return ModbusDevice(self.reads)

    def encode(self, frame: Frame) -> bytes:
        """Return all answers of one cycle, in the order of the reads."""
        device = self.device()
        return b"".join(device.answer_to(read, frame.values) for read in self.reads)


class EPick(ModbusRtu):
    """Robotiq EPick: 115200 8N1, unit 9; the pressure is in whole kPa, 100 is ambient (its manual, section 4)."""

    def __init__(self) -> None:
        vacuum = Register("vacuum", 1000.0, word=2, shift=8, bits=8, zero=100)
        read = Read(9, 0x07D0, (vacuum,), count=3, function=INPUT)
        super().__init__("modbus-rtu-epick", (read,), baudrate=115_200, period_us=20_000)


class OnRobotVG(ModbusRtu):
    """OnRobot VG10 and VGC10: 115200 8E1, unit 65; vacuum of both channels in 1/1000 of an atmosphere."""

    def __init__(self) -> None:
        channels = ("vacuum_a", "vacuum_b")
        registers = tuple(
            Register(name, -101.325, word=word, highest=1000) for word, name in enumerate(channels)
        )
        read = Read(65, 18, registers, count=2)
        super().__init__("modbus-rtu-onrobot-vg", (read,), baudrate=115_200, parity="E", period_us=50_000)


class Transmitters(ModbusRtu):
    """Four generic pressure transmitters on one bus: 9600 8N1, units 1 to 4, signed 0.1 kPa at 0x0016."""

    def __init__(self) -> None:
        channels = ("bottom", "cylinder", "top", "supply")
        reads = tuple(
            Read(unit, 0x0016, (Register(name, 100.0, signed=True, lowest=-1100, highest=20_000),))
            for unit, name in enumerate(channels, start=1)
        )
        super().__init__(
            "modbus-rtu-transmitters", reads, baudrate=9_600, period_us=200_000, timeout_us=60_000
        )
