"""What the decoders of ``ees1-ascii`` and ``ees1-cobs`` count, and what they judge alike."""

from __future__ import annotations

from collections import Counter

from end_effector_hal.codecs import _ees1 as ees1
from end_effector_hal.codecs._sequence import Sequence


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
        self._sequence = Sequence(seq_bits=ees1.SEQ_BITS, clock_bits=ees1.CLOCK_BITS)
        self._rest = b""

    @property
    def lost(self) -> int:
        """Frames missing by their sequence numbers."""
        return self._sequence.lost

    @property
    def reboots(self) -> int:
        """Jumps back of the device."""
        return self._sequence.reboots

    def _is_new(self, seq: int, clock: int) -> bool:
        if self._sequence.is_new(seq, clock):
            return True
        self.errors["duplicate"] += 1
        return False

    def _possible(self, pascal: int) -> int | None:
        """A pressure; None, and counted, where it is outside of what any sensor can mean."""
        if ees1.LOWEST_PA <= pascal <= ees1.HIGHEST_PA:
            return pascal
        self.errors["range"] += 1
        return None
