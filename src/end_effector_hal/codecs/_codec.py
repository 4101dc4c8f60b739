"""The codec: how frames stand on a wire. Pure: bytes in, frames out, no I/O, no clock."""

from __future__ import annotations

import builtins
from collections.abc import Mapping
from typing import Protocol

from end_effector_hal.signals import Frame, Kind


class Decoder(Protocol):
    """Finds frames in a stream of bytes; remembers a part of a frame, bounded in size."""

    @property
    def bytes(self) -> int:
        """All bytes fed."""
        ...

    @property
    def frames(self) -> int:
        """Frames returned."""
        ...

    @property
    def errors(self) -> Mapping[str, int]:
        """Thrown away: ``noise`` in bytes; ``format``, ``crc``, ``range``, ``duplicate`` in frames."""
        ...

    @property
    def lost(self) -> int:
        """Frames missing by their sequence numbers."""
        ...

    @property
    def reboots(self) -> int:
        """Jumps back of the sequence number or of the device's clock."""
        ...

    def feed(self, data: builtins.bytes, at: int) -> list[Frame]:
        """The frames that end in ``data``, in order; never raises, whatever the bytes.

        Args:
            data: what was read, in pieces of any size.
            at: µs, when it was read; becomes the ``at`` of the frames.
        """
        ...


class Codec(Protocol):
    """A wire format. A channel that is not in ``channels`` is not fitted.

    It may have more: ``parity``, ``resolution_pa``, ``seq_bits`` and ``clock_bits``; see `parity_of`,
    `resolution_of`, `sequence_of`.
    """

    @property
    def name(self) -> str:
        """As a description names it."""
        ...

    @property
    def channels(self) -> Mapping[str, Kind]:
        """What it carries."""
        ...

    @property
    def period_us(self) -> int:
        """Nominal time between two frames."""
        ...

    @property
    def baudrate(self) -> int:
        """Of the line, unless a description gives another; 8 bits, 1 stop bit, parity as `parity_of` says."""
        ...

    def decoder(self) -> Decoder:
        """A new one, for one stream."""
        ...

    def encode(self, frame: Frame) -> bytes:
        """The bytes of a frame; a channel that is missing or None is sent as invalid where the format can.

        Raises:
            UsageError: a value does not fit the format.
        """
        ...


def parity_of(codec: Codec) -> str:
    """``N``, ``E`` or ``O``: what the codec has as ``parity``; one without it is sent without."""
    return str(getattr(codec, "parity", "N"))


def resolution_of(codec: Codec) -> float:
    """Pa of the smallest step of a pressure: what the codec has as ``resolution_pa``, else 1."""
    return float(getattr(codec, "resolution_pa", 1))


FINE_PA = 50
"""A codec that counts in larger steps does not show the noise of a sensor: no value is called frozen."""


def shows_noise(codec: Codec) -> bool:
    """Whether it counts finely enough to tell a frozen sensor from a living one."""
    return resolution_of(codec) <= FINE_PA
