"""What the decoders of declared frames have in common: counters, and bytes that are not yet a frame."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from end_effector_hal.codecs.described._field import Field
from end_effector_hal.signals import Frame, Value

GAP_PERIODS = 5
"""After such a silence the bytes that come may begin anywhere in a frame."""


class DescribedDecoder:
    """Counters of one stream; a declared frame has no number and no clock.

    Args:
        period_us: nominal time between two frames.

    Attributes:
        bytes, frames: taken in and given out.
        errors: what was thrown away, by reason.
    """

    lost = 0
    reboots = 0

    def __init__(self, period_us: int) -> None:
        self.bytes = 0
        self.frames = 0
        self.errors: Counter[str] = Counter()
        self._rest = b""
        self._gap_us = GAP_PERIODS * period_us
        self._fed_at: int | None = None

    def _interrupted(self, at: int) -> bool:
        """Whether there was a gap before the bytes that come at ``at`` µs; what is unfinished is thrown away then."""
        before, self._fed_at = self._fed_at, at
        if before is None or at - before < self._gap_us:
            return False
        self.errors["noise"] += len(self._rest)
        self._rest = b""
        return True

    def _frame(self, at: int, fields: Sequence[Field], raws: Sequence[float | None]) -> Frame:
        """The frame of these raw values."""
        values: dict[str, Value] = {}
        for field, raw in zip(fields, raws, strict=True):
            values |= field.values(raw)
        self.errors["range"] += any(field.implausible(raw) for field, raw in zip(fields, raws, strict=True))
        self.frames += 1
        return Frame(at, None, None, values)
