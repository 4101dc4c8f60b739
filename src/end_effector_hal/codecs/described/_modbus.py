"""Registers and coils of Modbus devices: channels with nearby addresses are read with one request."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby

from end_effector_hal.codecs.described._codec import DescribedCodec, SerialLine, by_place
from end_effector_hal.codecs.described._field import Field, RawType
from end_effector_hal.codecs.modbus import ModbusMaster, ModbusRtu, Read
from end_effector_hal.codecs.modbus._codec import ModbusDevice
from end_effector_hal.codecs.modbus._read import COILS, DISCRETE_INPUTS, HOLDING, INPUT
from end_effector_hal.description import Channel, ModbusFrame, RegisterValue
from end_effector_hal.signals import Frame, Kind, Value

FUNCTIONS = {"coil": COILS, "discrete_input": DISCRETE_INPUTS, "holding": HOLDING, "input": INPUT}
LONGEST_READ = 100
"""Most registers or bits in one request; the standard allows 125."""
LAST_ADDRESS = 0xFFFF
LATENCY_US = 5_000
"""Time that a device may need before it answers, if the description gives no period, µs."""


class RegisterField:
    """A place in a device, and the channels that are read from it; a `Readout`.

    Args:
        place: the place in the device.
        channels: the channels by name.
        first: address of the first register in the same request.
    """

    def __init__(self, place: RegisterValue, channels: Mapping[str, Channel], first: int) -> None:
        self.channels = {name: each.kind for name, each in channels.items()}
        self.step_pa = max(
            channel.step_pa if channel.kind is Kind.PRESSURE else 1.0 for channel in channels.values()
        )
        self._at, self._size, self._little = (
            place.address - first,
            size_of(place),
            place.word_order == "little",
        )
        self._swaps = place.byte_order == "little"
        self._type = None if is_bit(place) else RawType(place.value_type, place.bitmask)
        self._field = Field(channels, (0, 1) if self._type is None else self._type.limits)

    def values(self, words: Sequence[int]) -> dict[str, Value]:
        """Return the values of the registers."""
        return self._field.values(self._raw(words))

    def implausible(self, words: Sequence[int]) -> bool:
        """Return whether no sensor can send these registers."""
        return self._field.implausible(self._raw(words))

    def _raw(self, words: Sequence[int]) -> float:
        mine = words[self._at : self._at + self._size]
        if self._type is None:
            return mine[0]
        word = 0
        for each in reversed(mine) if self._little else mine:
            word = word << 16 | (_swapped(each) if self._swaps else each)
        return self._type.raw(word)

    def put(self, words: list[int], values: Mapping[str, Value]) -> bool:
        """Write the device's values into the registers; return False if they cannot encode a missing value."""
        raw = self._field.raw(values)
        if raw is None:
            raw = self._type.none if self._type else None
        if raw is None:
            return False
        word = int(raw) if self._type is None else self._type.word(raw)
        for index in range(self._size):
            place = index if self._little else self._size - 1 - index
            register = word >> 16 * index & 0xFFFF
            words[self._at + place] |= _swapped(register) if self._swaps else register
        return True


def _swapped(register: int) -> int:
    """Return the register with its two bytes exchanged."""
    return (register & 0xFF) << 8 | register >> 8


class DescribedModbus(DescribedCodec):
    """The polled codec of declared registers and coils, of any number of units on one bus.

    Args:
        frame: settings for all of them.
        channels: the channels with their places.
        line: settings of the link.
    """

    def __init__(self, frame: ModbusFrame, channels: Mapping[str, Channel], line: SerialLine) -> None:
        reads = tuple(reads_of(by_place(channels, "modbus"), frame.gap))
        silence_us, pause_us = ModbusMaster.silence_us(line.baudrate), 1000 * frame.pause_ms
        wire_us = [
            line.wire_us(13 + read.answer_bytes, max(ModbusMaster.BITS, line.byte_bits))
            + silence_us
            + max(silence_us, pause_us)
            for read in reads
        ]
        super().__init__(channels, line, sum(wire_us))
        if line.period_us is None:
            self.period_us = max(self.PERIOD_US, self.least_period_us + LATENCY_US * len(reads))
        self._bus = ModbusRtu(
            self.name,
            reads,
            baudrate=self.baudrate,
            parity=self.parity,
            period_us=self.period_us,
            timeout_us=1000 * frame.timeout_ms,
            pause_us=pause_us,
            alike=True,
        )

    @property
    def reads(self) -> tuple[Read, ...]:
        """The requests of one cycle."""
        return self._bus.reads

    def decoder(self) -> ModbusMaster:
        """Return a new polled decoder."""
        return self._bus.decoder()

    def device(self) -> ModbusDevice:
        """Return one simulated device that answers for all devices of the bus."""
        return self._bus.device()

    def encode(self, frame: Frame) -> bytes:
        """Return all answers of one cycle, in the order of the requests."""
        return self._bus.encode(frame)


def is_bit(place: RegisterValue) -> bool:
    """Return whether the place is a coil or a discrete input."""
    return place.register_type in ("coil", "discrete_input")


def size_of(place: RegisterValue) -> int:
    """Return the number of registers or bits of a value."""
    return 1 if is_bit(place) or RawType(place.value_type).bits == 16 else 2


def reads_of(places: Mapping[RegisterValue, Mapping[str, Channel]], gap: int) -> Iterator[Read]:
    """Yield the requests for these places; one request covers places of one unit and table with gaps of at most
    ``gap`` addresses.

    Two answers of one unit and table differ in length, so that a late answer is never mistaken for another one. If
    their lengths would be equal, some more registers are read, at most ``gap``.
    """
    by_table = sorted(places, key=lambda each: (each.unit, each.register_type, each.address))
    for (unit, table), members in groupby(by_table, key=lambda each: (each.unit, each.register_type)):
        lengths: set[int] = set()
        for near in _near([*members], gap):
            first, end = near[0].address, max(each.address + size_of(each) for each in near)
            for count in range(end - first, end - first + gap + 1):
                if Read(unit, first, (), count, FUNCTIONS[table]).answer_bytes not in lengths:
                    first = min(first, LAST_ADDRESS + 1 - count)
                    end = first + count
                    break
            fields = tuple(RegisterField(each, places[each], first) for each in near)
            read = Read(unit, first, fields, end - first, FUNCTIONS[table])
            lengths.add(read.answer_bytes)
            yield read


def _near(places: Sequence[RegisterValue], gap: int) -> list[list[RegisterValue]]:
    """Return the sorted places in groups that are read together."""
    groups: list[list[RegisterValue]] = []
    end = 0
    for each in places:
        after = each.address + size_of(each)
        if groups and each.address - end <= gap and after - groups[-1][0].address <= LONGEST_READ:
            groups[-1].append(each)
        else:
            groups.append([each])
            end = 0
        end = max(end, after)
    return groups
