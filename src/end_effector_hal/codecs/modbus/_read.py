"""What is read from a Modbus device, and written to it, as data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from end_effector_hal.signals import Kind, Value

COILS, DISCRETE_INPUTS, HOLDING, INPUT = 1, 2, 3, 4
"""Function codes: Read Coils, Read Discrete Inputs, Read Holding Registers, Read Input Registers."""
BITS = (COILS, DISCRETE_INPUTS)
TABLES = {
    COILS: "coil",
    DISCRETE_INPUTS: "discrete input",
    HOLDING: "holding register",
    INPUT: "input register",
}


class Readout(Protocol):
    """What is taken from the registers, or the bits, of an answer."""

    @property
    def channels(self) -> Mapping[str, Kind]:
        """What it carries."""
        ...

    @property
    def step_pa(self) -> float:
        """Pa of one count; of a bit 1."""
        ...

    def values(self, words: Sequence[int]) -> dict[str, Value]:
        """What they mean; None: no value that the device can mean."""
        ...

    def implausible(self, words: Sequence[int]) -> bool:
        """Whether the device cannot mean them."""
        ...

    def put(self, words: list[int], values: Mapping[str, Value]) -> bool:
        """RegisterWrite what a device shows; False: it can only refuse, as there is no value."""
        ...


@dataclass(frozen=True)
class Register:
    """Where a gauge pressure stands in an answer: ``(raw - zero) * scale_pa``.

    Args:
        channel: its name on the link.
        scale_pa: Pa per count; negative where the device counts vacuum as positive.
        word: which of the registers that are read, from 0 on.
        shift, bits: which bits of the register.
        signed: two's complement.
        zero: the raw value at ambient pressure.
        lowest, highest: raw values that the device can mean; others are invalid. Default: all that fit.
    """

    channel: str
    scale_pa: float
    word: int = 0
    shift: int = 0
    bits: int = 16
    signed: bool = False
    zero: int = 0
    lowest: int | None = None
    highest: int | None = None

    @property
    def channels(self) -> Mapping[str, Kind]:
        """What it carries."""
        return {self.channel: Kind.PRESSURE}

    @property
    def step_pa(self) -> float:
        """Pa of one count."""
        return abs(self.scale_pa)

    def values(self, words: Sequence[int]) -> dict[str, Value]:
        """Gauge Pa, or None: no value that the device can mean."""
        return {self.channel: self.value(words[self.word])}

    def implausible(self, words: Sequence[int]) -> bool:
        """Whether the device cannot mean them."""
        return self.value(words[self.word]) is None

    def put(self, words: list[int], values: Mapping[str, Value]) -> bool:
        """The bits of a register; False: there is no value."""
        value = values.get(self.channel)
        if value is not None:
            words[self.word] |= self.word_of(value)
        return value is not None

    @property
    def limits(self) -> tuple[int, int]:
        """The lowest and the highest raw value."""
        half = 1 << (self.bits - 1)
        low, high = (-half, half - 1) if self.signed else (0, 2 * half - 1)
        return low if self.lowest is None else self.lowest, high if self.highest is None else self.highest

    def value(self, word: int) -> Value:
        """Gauge Pa, or None: no value that the device can mean."""
        raw = word >> self.shift & ((1 << self.bits) - 1)
        if self.signed and raw >> (self.bits - 1):
            raw -= 1 << self.bits
        low, high = self.limits
        return round((raw - self.zero) * self.scale_pa) if low <= raw <= high else None

    def word_of(self, pascal: int) -> int:
        """The bits of a register; what lies beyond the device's range is shown at its end, as sensors do."""
        low, high = self.limits
        raw = min(max(round(pascal / self.scale_pa) + self.zero, low), high)
        return (raw & ((1 << self.bits) - 1)) << self.shift


@dataclass(frozen=True)
class Read:
    """One request: ``count`` registers, or bits, of a unit from ``address`` on.

    Args:
        unit: address of the device, 1 to 247.
        address: of the first, as it stands on the wire.
        registers: what is taken from the answer.
        count: how many are read.
        function: `HOLDING`, `INPUT`, `COILS` or `DISCRETE_INPUTS`.
    """

    unit: int
    address: int
    registers: tuple[Readout, ...]
    count: int = 1
    function: int = HOLDING

    @property
    def place(self) -> str:
        """For a sentence: ``Unit 3, holding registers 22 to 23 (bottom)``."""
        last = self.address + self.count - 1
        several = f"s {self.address} to {last}" if self.count > 1 else f" {self.address}"
        names = ", ".join(name for part in self.registers for name in part.channels)
        return f"Unit {self.unit}, {TABLES[self.function]}{several} ({names})"

    @property
    def form(self) -> tuple[int, int, int]:
        """Unit, function and length: all that tells its answer from others."""
        return self.unit, self.function, self.answer_bytes

    @property
    def answer_bytes(self) -> int:
        """Bytes of what was read in its answer; two answers of one unit and function are told apart by it."""
        return -(-self.count // 8) if self.function in BITS else 2 * self.count


@dataclass(frozen=True)
class RegisterWrite:
    """One request that sets registers, or coils, of a unit from ``address`` on, all of them or none.

    Args:
        unit: address of the device, 1 to 247.
        address: of the first, as it stands on the wire.
        values: 0 to 65535 each; of coils 0 or 1.
        coils: whether they are coils.
        multiple: whether also one of them is written as several are.
    """

    unit: int
    address: int
    values: tuple[int, ...]
    coils: bool = False
    multiple: bool = False

    @property
    def single(self) -> bool:
        """Whether it is written with the function for one."""
        return len(self.values) == 1 and not self.multiple
