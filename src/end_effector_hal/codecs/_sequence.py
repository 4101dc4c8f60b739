"""Sequence numbers: what is lost, repeated, or begins anew."""

from __future__ import annotations

from typing import ClassVar

from end_effector_hal.codecs._codec import Codec


class Sequence:
    """Judges the sequence numbers and the device's clock of one stream; both wrap around.

    A jump back by less than half of the range (of the number or of the clock) is a reboot of the device.

    Args:
        seq_bits, clock_bits: their width.
    """

    MEMORY: ClassVar = {"lost": int, "reboots": int, "_last": tuple[int, int] | None}
    """What changes while frames come, for a recording that begins in the middle."""

    def __init__(self, *, seq_bits: int, clock_bits: int) -> None:
        self.lost = 0
        self.reboots = 0
        self._seq_mod, self._clock_mod = 1 << seq_bits, 1 << clock_bits
        self._last: tuple[int, int] | None = None

    def is_new(self, seq: int, device_ms: int) -> bool:
        """Whether this frame is to be delivered; a repeated number is not."""
        last, self._last = self._last, (seq, device_ms)
        if last is None:
            return True
        step = (seq - last[0]) % self._seq_mod
        clock_back = (device_ms - last[1]) % self._clock_mod >= self._clock_mod // 2
        if step == 0 and not clock_back:
            self._last = last
            return False
        if clock_back or step >= self._seq_mod // 2:
            self.reboots += 1
        else:
            self.lost += step - 1
        return True


def sequence_of(codec: Codec) -> Sequence:
    """For frames of a codec; 16 and 32 bits, unless it has other ``seq_bits`` and ``clock_bits``."""
    return Sequence(seq_bits=getattr(codec, "seq_bits", 16), clock_bits=getattr(codec, "clock_bits", 32))
