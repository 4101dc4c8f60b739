"""Checks of the results of a codec, which may be third-party code: frames and counters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from end_effector_hal.codecs._codec import Decoder
from end_effector_hal.signals import Frame, Kind

MOST_KINDS = 64
"""Most kinds of errors that a decoder may count."""


@dataclass(frozen=True, slots=True)
class Counters:
    """Counters since the start; see `Decoder`."""

    bytes: int = 0
    frames: int = 0
    lost: int = 0
    reboots: int = 0
    errors: Mapping[str, int] = field(default_factory=dict)

    def plus(self, other: Counters) -> Counters:
        """Return the sum with the counters of an earlier decoder."""
        kinds = {**self.errors, **other.errors}
        errors = {kind: self.errors.get(kind, 0) + other.errors.get(kind, 0) for kind in kinds}
        return Counters(
            self.bytes + other.bytes,
            self.frames + other.frames,
            self.lost + other.lost,
            self.reboots + other.reboots,
            errors,
        )


def counters_of(decoder: Decoder) -> Counters | None:
    """Return a snapshot of a decoder's counters; None: they are not valid."""
    numbers = (decoder.bytes, decoder.frames, decoder.lost, decoder.reboots)
    errors = dict(decoder.errors)
    named = all(type(kind) is str and kind.isprintable() and len(kind) <= 40 for kind in errors)
    if not named or len(errors) > MOST_KINDS:
        return None
    if not all(type(each) is int and 0 <= each < 2**63 for each in (*numbers, *errors.values())):
        return None
    return Counters(*numbers, errors)


HIGHEST_PA = 2**31 - 1
HIGHEST_CLOCK = 2**63 - 1


def frame_fault(frame: object, kinds: Mapping[str, Kind], last: int, now: int) -> str:
    """Return the fault of a frame, as the end of a sentence; empty: it has none.

    Args:
        frame: the object that the decoder returned.
        kinds: the kinds of the codec's channels.
        last: stamp of the previous frame, µs.
        now: the time now, µs.
    """
    if type(frame) is not Frame:
        return "something else than frames"
    if type(frame.at) is not int or not last <= frame.at <= now:
        return "a frame whose stamp is ahead of now, before the last one, or no time"
    if not _counts(frame.seq, HIGHEST_PA) or not _counts(frame.device_ms, HIGHEST_CLOCK):
        return "a frame whose number or clock is no whole number in its range"
    for channel, value in frame.values.items():
        kind = kinds.get(channel) if type(channel) is str else None
        if kind is None:
            return "a frame with a channel that the codec does not declare"
        if value is None:
            continue
        if kind is Kind.BIT and type(value) is not bool:
            return f"a frame whose bit {channel} is neither true nor false"
        if kind is Kind.PRESSURE and (type(value) is not int or abs(value) > HIGHEST_PA):
            return f"a frame whose pressure {channel} is no whole number of Pa"
        if kind is Kind.QUANTITY and (type(value) is not int or abs(value) > HIGHEST_PA):
            return f"a frame whose quantity {channel} is no whole number of thousandths"
        if kind is Kind.CODE and (type(value) is not int or abs(value) > HIGHEST_PA):
            return f"a frame whose code {channel} is no whole number"
    return ""


def _counts(value: object, highest: int) -> bool:
    return value is None or (type(value) is int and 0 <= value <= highest)
