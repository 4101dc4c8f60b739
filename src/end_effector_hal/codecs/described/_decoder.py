"""What the decoders of declared frames have in common: counters, and bytes that are not yet a frame."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from end_effector_hal.codecs.described._field import Field
from end_effector_hal.signals import Frame, Value


class DescribedDecoder:
    """Counters of one stream; a declared frame has no number and no clock.

    Attributes:
        bytes, frames: taken in and given out.
        errors: what was thrown away, by reason.
    """

    lost = 0
    reboots = 0

    def __init__(self) -> None:
        self.bytes = 0
        self.frames = 0
        self.errors: Counter[str] = Counter()
        self._rest = b""

    def _frame(self, at: int, fields: Sequence[Field], raws: Sequence[float | None]) -> Frame:
        """The frame of these raw values."""
        values: dict[str, Value] = {}
        for field, raw in zip(fields, raws, strict=True):
            values |= field.values(raw)
        self.errors["range"] += any(field.implausible(raw) for field, raw in zip(fields, raws, strict=True))
        self.frames += 1
        return Frame(at, None, None, values)
