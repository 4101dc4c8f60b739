"""Codecs with channel names chosen by the user, so that two devices of the same kind fit into one tool."""

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
"""The user's name of a channel, by the codec's name; channels that are not listed are left out."""


def renamed(codec: Codec, names: Names) -> Codec:
    """Return the codec with other channel names."""
    return RenamedPolledCodec(codec, names) if is_polled(codec) else RenamedCodec(codec, names)


class RenamedCodec:
    """A streaming codec with other channel names.

    Args:
        codec: the codec to rename.
        names: the new names of its channels.
    """

    def __init__(self, codec: Codec, names: Names) -> None:
        self._codec, self._names = codec, names
        self.name = codec.name
        self.channels: Mapping[str, Kind] = {mine: codec.channels[its] for its, mine in names.items()}
        self.period_us, self.baudrate, self.parity = codec.period_us, codec.baudrate, parity_of(codec)
        self.resolution_pa = resolution_of(codec)

    def decoder(self) -> Decoder:
        """Return a new decoder for one stream."""
        return RenamedDecoder(self._codec.decoder(), self._names)

    def encode(self, frame: Frame) -> bytes:
        """Return the bytes of a frame."""
        return self._codec.encode(replace(frame, values=_its(self._names, frame.values)))


class RenamedDecoder:
    """A decoder whose frames have the user's channel names."""

    def __init__(self, decoder: Decoder, names: Names) -> None:
        self._decoder, self._names = decoder, names

    @property
    def bytes(self) -> int:
        """Number of bytes fed."""
        return self._decoder.bytes

    @property
    def frames(self) -> int:
        """Number of frames returned."""
        return self._decoder.frames

    @property
    def errors(self) -> Mapping[str, int]:
        """Counts of discarded data, by reason."""
        return self._decoder.errors

    @property
    def lost(self) -> int:
        """Number of frames that are missing according to the sequence numbers."""
        return self._decoder.lost

    @property
    def reboots(self) -> int:
        """Number of reboots of the device, detected by backward jumps."""
        return self._decoder.reboots

    def feed(self, data: builtins.bytes, at: int) -> list[Frame]:
        """Return the frames that end in ``data``."""
        return [self._mine(frame) for frame in self._decoder.feed(data, at)]

    def _mine(self, frame: Frame) -> Frame:
        names = self._names
        values = {names[its]: value for its, value in frame.values.items() if its in names}
        return replace(frame, values=values)


class RenamedPolledCodec(RenamedCodec):
    """A polled codec with other channel names."""

    def __init__(self, codec: PolledCodec, names: Names) -> None:
        super().__init__(codec, names)
        self._polled = codec

    def decoder(self) -> PolledDecoder:
        """Return a new polled decoder."""
        return RenamedPolledDecoder(self._polled.decoder(), self._names)

    def device(self) -> Device:
        """Return the simulated device, which uses the codec's own channel names."""
        return RenamedDevice(self._polled.device(), self._names)


class RenamedPolledDecoder(RenamedDecoder):
    """A polled decoder with other channel names."""

    def __init__(self, decoder: PolledDecoder, names: Names) -> None:
        super().__init__(decoder, names)
        self._poller = decoder

    @property
    def due(self) -> int:
        """Time of the next call of `poll`, µs."""
        return self._poller.due

    def poll(self, at: int) -> Polled:
        """Return the next request, and the frames that ended because an answer is missing."""
        data, frames = self._poller.poll(at)
        return Polled(data, tuple(map(self._mine, frames)))


class RenamedDevice:
    """The simulated device of a polled link, with the user's channel names."""

    def __init__(self, device: Device, names: Names) -> None:
        self._device, self._names = device, names

    def answer(self, data: bytes, values: Mapping[str, Value]) -> bytes:
        """Return the answers to the requests that end in ``data``."""
        return self._device.answer(data, _its(self._names, values))


def _its(names: Names, values: Mapping[str, Value]) -> dict[str, Value]:
    return {its: values[mine] for its, mine in names.items() if mine in values}
