"""What ``ees1-ascii`` and ``ees1-cobs`` have in common: the channels of EES1, the order of its bits, its decoder."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import ClassVar

from end_effector_hal.codecs._codec import Sequence
from end_effector_hal.errors import UsageError
from end_effector_hal.signals import Frame, Kind, Value

PRESSURES = ("bottom", "cylinder", "top", "supply")
BITS = (
    "locked",
    "unlocked",
    "tool_present",
    "in_stand",
    "cylinder_extended",
    "cylinder_retracted",
    "estop_ok",
)
SEQ_BITS, CLOCK_BITS = 16, 32
# From below the lowest possible vacuum to above any shop-air supply: outside of it a sensor is broken.
LOWEST_PA, HIGHEST_PA = -110_000, 2_000_000


class Ees1Codec:
    """Four pressures and seven bits, 50 Hz at 115200 baud."""

    name: ClassVar[str]
    channels: Mapping[str, Kind] = dict.fromkeys(PRESSURES, Kind.PRESSURE) | dict.fromkeys(BITS, Kind.BIT)
    period_us = 20_000
    baudrate = 115_200

    def _pressure(self, name: str, pascal: int, highest: int = HIGHEST_PA) -> int:
        """In whole Pa; raises UsageError if the format cannot carry it."""
        if not LOWEST_PA <= pascal <= highest:
            raise UsageError(
                f"the pressure {name} = {pascal} Pa does not fit {self.name}",
                todo=f"Give gauge Pa from {LOWEST_PA} to {highest}.",
            )
        return int(pascal)

    def _head(self, frame: Frame) -> tuple[int, int]:
        """Sequence number and clock, which wrap around; None counts as 0."""
        return (frame.seq or 0) % (1 << SEQ_BITS), (frame.device_ms or 0) % (1 << CLOCK_BITS)

    def _din(self, frame: Frame) -> int:
        """The bits as one byte; a missing bit is false."""
        return sum(1 << bit for bit, name in enumerate(BITS) if frame.values.get(name))


class Ees1Decoder:
    """Counters of one stream; the format itself is the subclass's.

    Attributes:
        bytes, frames: taken in and given out.
        errors: what was thrown away, by reason.
    """

    def __init__(self) -> None:
        self.bytes = 0
        self.frames = 0
        self.errors: Counter[str] = Counter()
        self._sequence = Sequence(seq_bits=SEQ_BITS, clock_bits=CLOCK_BITS)
        self._rest = b""

    @property
    def lost(self) -> int:
        """Frames missing by their sequence numbers."""
        return self._sequence.lost

    @property
    def reboots(self) -> int:
        """Jumps back of the device."""
        return self._sequence.reboots

    def _frame(
        self, at: int, seq: int, clock: int, pressures: Iterable[int | None], din: int
    ) -> Frame | None:
        """The frame of what was decoded; None, and counted, for one that came before."""
        if not self._sequence.is_new(seq, clock):
            self.errors["duplicate"] += 1
            return None
        values: dict[str, Value] = {
            name: self._possible(pascal) for name, pascal in zip(PRESSURES, pressures, strict=True)
        }
        values |= {name: bool(din >> bit & 1) for bit, name in enumerate(BITS)}
        return Frame(at, seq, clock, values)

    def _possible(self, pascal: int | None) -> int | None:
        """A pressure; None, and counted, where it is outside of what any sensor can mean."""
        if pascal is None or LOWEST_PA <= pascal <= HIGHEST_PA:
            return pascal
        self.errors["range"] += 1
        return None
