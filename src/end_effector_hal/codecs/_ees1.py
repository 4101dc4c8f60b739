"""The common parts of ``ees1-ascii`` and ``ees1-cobs``: the channels of EES1, the order of its bits, its decoder."""

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
_LEVELS = [{name: bool(din >> bit & 1) for bit, name in enumerate(BITS)} for din in range(1 << len(BITS))]
# From below the lowest possible vacuum to above any shop-air supply: outside of it a sensor is broken.
LOWEST_PA, HIGHEST_PA = -110_000, 2_000_000


class Ees1Codec:
    """Four pressures and seven bits, 50 Hz at 115200 baud."""

    name: ClassVar[str]
    channels: Mapping[str, Kind] = dict.fromkeys(PRESSURES, Kind.PRESSURE) | dict.fromkeys(BITS, Kind.BIT)
    period_us = 20_000
    baudrate = 115_200

    def _pressure(self, name: str, pascal: int, highest: int = HIGHEST_PA) -> int:
        """Return the pressure in whole Pa; raises UsageError if the format cannot encode it."""
        if not LOWEST_PA <= pascal <= highest:
            raise UsageError(
                f"the pressure {name} = {pascal} Pa does not fit {self.name}",
                todo=f"Give gauge Pa from {LOWEST_PA} to {highest}.",
            )
        return int(pascal)

    def _head(self, frame: Frame) -> tuple[int, int]:
        """Return sequence number and clock, which wrap around; None counts as 0."""
        return (frame.seq or 0) % (1 << SEQ_BITS), (frame.device_ms or 0) % (1 << CLOCK_BITS)

    def _din(self, frame: Frame) -> int:
        """Return the bits as one byte; a missing bit is false."""
        return sum(1 << bit for bit, name in enumerate(BITS) if frame.values.get(name))


class Ees1Decoder:
    """The counters of one stream; subclasses implement the format.

    Attributes:
        bytes, frames: number of bytes fed and of frames returned.
        errors: counts of discarded data, by reason.
    """

    def __init__(self) -> None:
        self.bytes = 0
        self.frames = 0
        self.errors: Counter[str] = Counter()
        self._sequence = Sequence(seq_bits=SEQ_BITS, clock_bits=CLOCK_BITS)
        self._rest = b""

    @property
    def lost(self) -> int:
        """Number of frames that are missing according to the sequence numbers."""
        return self._sequence.lost

    @property
    def reboots(self) -> int:
        """Number of reboots of the device, detected by backward jumps."""
        return self._sequence.reboots

    def _frame(
        self, at: int, seq: int, clock: int, pressures: Iterable[int | None], din: int
    ) -> Frame | None:
        """Return the decoded frame; None: its sequence number is repeated (it is counted as duplicate)."""
        if not self._sequence.is_new(seq, clock):
            self.errors["duplicate"] += 1
            return None
        values: dict[str, Value] = dict(zip(PRESSURES, map(self._possible, pressures), strict=True))
        values |= _LEVELS[din % len(_LEVELS)]
        return Frame(at, seq, clock, values)

    def _possible(self, pascal: int | None) -> int | None:
        """Return the pressure; None if it is outside the range of any sensor (it is counted)."""
        if pascal is None or LOWEST_PA <= pascal <= HIGHEST_PA:
            return pascal
        self.errors["range"] += 1
        return None
