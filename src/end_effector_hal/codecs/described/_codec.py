"""The common parts of declared codecs and their decoders: counters, and the bytes of an unfinished frame."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter, deque
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from end_effector_hal.codecs._codec import Decoder
from end_effector_hal.codecs.described._field import Field
from end_effector_hal.description import Channel, part_of
from end_effector_hal.signals import Frame, Kind, Value


class SerialLine(NamedTuple):
    """Settings of a serial line; ``baudrate`` 0: there is none; ``period_us`` None: it follows from the format."""

    baudrate: int
    parity: str
    period_us: int | None
    stopbits: int = 1

    @property
    def byte_bits(self) -> int:
        """Bits of a byte on the line: start, 8, parity, stop."""
        return 9 + (self.parity != "N") + self.stopbits

    def wire_us(self, count: int, bits: int | None = None) -> int:
        """Return the time that so many bytes need on the line, µs; 0 if there is none."""
        return count * (bits or self.byte_bits) * 1_000_000 // self.baudrate if self.baudrate else 0


class DescribedCodec(ABC):
    """The base of declared codecs: everything except the format.

    Args:
        channels: the channels of the link.
        line: settings of the link.
        least_period_us: shortest time to transmit a frame, µs.
    """

    name = "the declared frame"
    PERIOD_US = 20_000

    def __init__(self, channels: Mapping[str, Channel], line: SerialLine, least_period_us: int) -> None:
        self.channels: Mapping[str, Kind] = {name: each.kind for name, each in channels.items()}
        steps = [channel.step_pa for channel in channels.values() if channel.kind is Kind.PRESSURE]
        self.resolution_pa = max(steps, default=1.0)
        self.baudrate, self.parity = line.baudrate, line.parity
        self.least_period_us = least_period_us
        self.period_us = line.period_us or max(self.PERIOD_US, least_period_us)

    @abstractmethod
    def decoder(self) -> Decoder:
        """Return a new decoder for one stream."""

    @abstractmethod
    def encode(self, frame: Frame) -> bytes:
        """Return the bytes of a frame; each value is rounded to the nearest one of its raw type."""


def by_place(channels: Mapping[str, Channel], source: str) -> dict[Any, dict[str, Channel]]:
    """Return the channels of one source, by their places on the wire."""
    found: dict[Any, dict[str, Channel]] = {}
    for name, each in channels.items():
        found.setdefault(part_of(each, source), {})[name] = each
    return found


GAP_PERIODS, GAP_MEASURED = 5, 3
"""Length of a gap, in declared or in measured periods; after a gap the bytes may begin anywhere in a frame."""
MEASURED, LONGEST_US = 5, 10_000_000
"""Number of times between two frames whose median is used, and the longest time that counts, µs."""


class DescribedDecoder:
    """The counters of one stream; a declared frame has no sequence number and no clock.

    Args:
        period_us: nominal time between two frames.

    Attributes:
        bytes, frames: number of bytes fed and of frames returned.
        errors: counts of discarded data, by reason.
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
        self._ended_at: int | None = None
        self._apart: deque[int] = deque(maxlen=MEASURED)

    def _interrupted(self, at: int, ended: int) -> bool:
        """Return whether there was a gap before the bytes that arrived at ``at`` µs; an unfinished frame is then
        discarded.

        A device may be slower than declared, so a gap must also be longer than the recent time between two frames.
        ``ended``: number of frames that may end in these bytes.
        """
        before, self._fed_at = self._fed_at, at
        usual = sorted(self._apart)[(len(self._apart) - 1) // 2] if len(self._apart) > 1 else 0
        if ended:
            if self._ended_at is not None:
                self._apart.append((at - self._ended_at) // ended)
            self._ended_at = at
        gap_us = GAP_MEASURED * min(usual, LONGEST_US) if 2 * usual >= self._gap_us else self._gap_us
        if before is None or at - before < max(self._gap_us, gap_us):
            return False
        self.errors["noise"] += len(self._rest)
        self._rest = b""
        return True

    def _frame(self, at: int, fields: Sequence[Field], raws: Sequence[float | str | None]) -> Frame:
        """Return the frame of these raw values."""
        values: dict[str, Value] = {}
        for field, raw in zip(fields, raws, strict=True):
            values |= field.values(raw)
        self.errors["range"] += any(field.implausible(raw) for field, raw in zip(fields, raws, strict=True))
        self.frames += 1
        return Frame(at, None, None, values)
