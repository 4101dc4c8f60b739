"""What is read from a Modbus device, as data."""

from __future__ import annotations

from dataclasses import dataclass

from end_effector_hal.signals import Value

HOLDING, INPUT = 3, 4
"""Function codes: Read Holding Registers, Read Input Registers."""


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
    """One request: ``count`` registers of a unit from ``address`` on.

    Args:
        unit: address of the device, 1 to 247.
        address: of the first register, as it stands on the wire.
        registers: what is taken from the answer.
        count: how many registers are read.
        function: `HOLDING` or `INPUT`.
    """

    unit: int
    address: int
    registers: tuple[Register, ...]
    count: int = 1
    function: int = HOLDING
