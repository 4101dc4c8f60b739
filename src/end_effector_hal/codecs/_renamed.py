"""A codec whose channels have names of the user's own: so two of the same kind fit into one tool."""

from __future__ import annotations

import builtins
from collections.abc import Mapping
from dataclasses import replace

from end_effector_hal.codecs._codec import (
    Codec,
    Decoder,
    Device,
    Polled,
    PolledCodec,
    PolledDecoder,
    is_polled,
    parity_of,
    resolution_of,
)
from end_effector_hal.signals import Frame, Kind, Value

Names = Mapping[str, str]
"""The user's name of a channel, by that of the codec; others are left out."""


def renamed(codec: Codec, names: Names) -> Codec:
    """The same codec, whose channels have other names."""
    return RenamedPolledCodec(codec, names) if is_polled(codec) else RenamedCodec(codec, names)


class RenamedCodec:
    """A codec that streams, with other names.

    Args:
        codec: that it is.
        names: of its channels.
    """

    def __init__(self, codec: Codec, names: Names) -> None:
        self._codec, self._names = codec, names
        self.name = codec.name
        self.channels: Mapping[str, Kind] = {mine: codec.channels[its] for its, mine in names.items()}
        self.period_us, self.baudrate, self.parity = codec.period_us, codec.baudrate, parity_of(codec)
        self.resolution_pa = resolution_of(codec)
        self.seq_bits, self.clock_bits = getattr(codec, "seq_bits", 16), getattr(codec, "clock_bits", 32)

    def decoder(self) -> Decoder:
        """A new one, for one stream."""
        return RenamedDecoder(self._codec.decoder(), self._names)

    def encode(self, frame: Frame) -> bytes:
        """The bytes of a frame."""
        return self._codec.encode(replace(frame, values=_its(self._names, frame.values)))


class RenamedDecoder:
    """Its frames have the user's names."""

    def __init__(self, decoder: Decoder, names: Names) -> None:
        self._decoder, self._names = decoder, names

    @property
    def bytes(self) -> int:
        """All bytes fed."""
        return self._decoder.bytes

    @property
    def frames(self) -> int:
        """Frames returned."""
        return self._decoder.frames

    @property
    def errors(self) -> Mapping[str, int]:
        """Thrown away, by reason."""
        return self._decoder.errors

    @property
    def lost(self) -> int:
        """Frames missing by their sequence numbers."""
        return self._decoder.lost

    @property
    def reboots(self) -> int:
        """Jumps back of the device."""
        return self._decoder.reboots

    def feed(self, data: builtins.bytes, at: int) -> list[Frame]:
        """The frames that end in ``data``."""
        return [self._mine(frame) for frame in self._decoder.feed(data, at)]

    def _mine(self, frame: Frame) -> Frame:
        names = self._names
        values = {names[its]: value for its, value in frame.values.items() if its in names}
        return replace(frame, values=values)


class RenamedPolledCodec(RenamedCodec):
    """A codec that asks, with other names."""

    def __init__(self, codec: PolledCodec, names: Names) -> None:
        super().__init__(codec, names)
        self._polled = codec

    def decoder(self) -> PolledDecoder:
        """A new one, which asks."""
        return RenamedPolledDecoder(self._polled.decoder(), self._names)

    def device(self) -> Device:
        """The other end, which knows its own names only."""
        return RenamedDevice(self._polled.device(), self._names)


class RenamedPolledDecoder(RenamedDecoder):
    """A decoder that asks, with other names."""

    def __init__(self, decoder: PolledDecoder, names: Names) -> None:
        super().__init__(decoder, names)
        self._poller = decoder

    @property
    def due(self) -> int:
        """µs at which `poll` is to be called next."""
        return self._poller.due

    def poll(self, at: int) -> Polled:
        """The next request, and the frames that ended for want of an answer."""
        data, frames = self._poller.poll(at)
        return Polled(data, tuple(map(self._mine, frames)))


class RenamedDevice:
    """The other end of a polled link."""

    def __init__(self, device: Device, names: Names) -> None:
        self._device, self._names = device, names

    def answer(self, data: bytes, values: Mapping[str, Value]) -> bytes:
        """The answers to the requests that end in ``data``."""
        return self._device.answer(data, _its(self._names, values))


def _its(names: Names, values: Mapping[str, Value]) -> dict[str, Value]:
    return {its: values[mine] for its, mine in names.items() if mine in values}
