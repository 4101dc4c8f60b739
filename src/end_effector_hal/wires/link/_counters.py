"""The counters of a decoder, as plain numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from end_effector_hal.codecs import Decoder

MOST_KINDS = 64
"""Kinds of errors that a decoder may count."""


@dataclass(frozen=True, slots=True)
class Counters:
    """Since the start; see `Decoder`."""

    bytes: int = 0
    frames: int = 0
    lost: int = 0
    reboots: int = 0
    errors: Mapping[str, int] = field(default_factory=dict)

    def plus(self, other: Counters) -> Counters:
        """The sum with those of a decoder that came before."""
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
    """A snapshot; None: they are no counters."""
    numbers = (decoder.bytes, decoder.frames, decoder.lost, decoder.reboots)
    errors = dict(decoder.errors)
    named = all(type(kind) is str and kind.isprintable() and len(kind) <= 40 for kind in errors)
    if not named or len(errors) > MOST_KINDS:
        return None
    if not all(type(each) is int and 0 <= each < 2**63 for each in (*numbers, *errors.values())):
        return None
    return Counters(*numbers, errors)
