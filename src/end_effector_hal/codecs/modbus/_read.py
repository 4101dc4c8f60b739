"""Reads from and writes to a Modbus device, as data."""

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
    """The values in some registers or bits of an answer."""

    @property
    def channels(self) -> Mapping[str, Kind]:
        """The kinds of its channels, by name."""
        ...

    @property
    def step_pa(self) -> float:
        """Pa of one count; 1 for a bit."""
        ...

    def values(self, words: Sequence[int]) -> dict[str, Value]:
        """Return the values of the registers; None: the device cannot send this value."""
        ...

    def implausible(self, words: Sequence[int]) -> bool:
        """Return whether the device cannot send these registers."""
        ...

    def put(self, words: list[int], values: Mapping[str, Value]) -> bool:
        """Write the device's values into the registers; return False if a missing value cannot be encoded."""
        ...


@dataclass(frozen=True)
class Register:
    """The place of a gauge pressure in an answer: ``(raw - zero) * scale_pa``.

    Args:
        channel: its name on the link.
        scale_pa: Pa per count; negative if the device counts vacuum as positive.
        word: index of the register in the answer, from 0 on.
        shift, bits: position and number of the bits in the register.
        signed: two's complement.
        zero: the raw value at ambient pressure.
        lowest, highest: limits of the raw values that the device can send; others are invalid. Default: no limits.
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
        """The kind of its channel, by name."""
        return {self.channel: Kind.PRESSURE}

    @property
    def step_pa(self) -> float:
        """Pa of one count."""
        return abs(self.scale_pa)

    def values(self, words: Sequence[int]) -> dict[str, Value]:
        """Return the value in gauge Pa; None: the device cannot send this value."""
        return {self.channel: self.value(words[self.word])}

    def implausible(self, words: Sequence[int]) -> bool:
        """Return whether the device cannot send this register."""
        return self.value(words[self.word]) is None

    def put(self, words: list[int], values: Mapping[str, Value]) -> bool:
        """Write the value into its register; return False if there is no value."""
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
        """Return the value in gauge Pa; None: the device cannot send this value."""
        raw = word >> self.shift & ((1 << self.bits) - 1)
        if self.signed and raw >> (self.bits - 1):
            raw -= 1 << self.bits
        low, high = self.limits
        return round((raw - self.zero) * self.scale_pa) if low <= raw <= high else None

    def word_of(self, pascal: int) -> int:
        """Return the bits of a register; a value beyond the device's range becomes its end, as in sensors."""
        low, high = self.limits
        raw = min(max(round(pascal / self.scale_pa) + self.zero, low), high)
        return (raw & ((1 << self.bits) - 1)) << self.shift


@dataclass(frozen=True)
class Read:
    """One request that reads ``count`` registers or bits of a unit from ``address`` on.

    Args:
        unit: address of the device, 0 to 255.
        address: first address, as on the wire.
        registers: the values in the answer.
        count: number of registers or bits.
        function: `HOLDING`, `INPUT`, `COILS` or `DISCRETE_INPUTS`.
    """

    unit: int
    address: int
    registers: tuple[Readout, ...]
    count: int = 1
    function: int = HOLDING

    @property
    def place(self) -> str:
        """The place for messages: ``Unit 3, holding registers 22 to 23 (bottom)``."""
        last = self.address + self.count - 1
        several = f"s {self.address} to {last}" if self.count > 1 else f" {self.address}"
        names = ", ".join(name for part in self.registers for name in part.channels)
        return f"Unit {self.unit}, {TABLES[self.function]}{several} ({names})"

    @property
    def form(self) -> tuple[int, int, int]:
        """Unit, function and length: all that distinguishes its answer from others."""
        return self.unit, self.function, self.answer_bytes

    @property
    def answer_bytes(self) -> int:
        """Number of data bytes in its answer; it distinguishes two answers of one unit and function."""
        return -(-self.count // 8) if self.function in BITS else 2 * self.count


@dataclass(frozen=True)
class RegisterWrite:
    """One request that sets registers or coils of a unit from ``address`` on, all of them or none.

    Args:
        unit: address of the device, 0 to 255.
        address: first address, as on the wire.
        values: 0 to 65535 each; 0 or 1 for coils.
        coils: whether coils are written.
        multiple: whether the Modbus function for several values is used even for one.
        mask: bits of one register that are set, with the function Mask Write Register; None: whole registers.
    """

    unit: int
    address: int
    values: tuple[int, ...]
    coils: bool = False
    multiple: bool = False
    mask: int | None = None

    @property
    def single(self) -> bool:
        """Whether the Modbus function for a single value is used, whose answer repeats the request."""
        return len(self.values) == 1 and not self.multiple
