"""Codecs by name: the built-in ones and those of other distributions; their declarations are checked once."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from end_effector_hal.codecs._codec import Codec, Decoder, Device, PolledCodec, PolledDecoder, is_polled
from end_effector_hal.errors import UsageError
from end_effector_hal.plugins import Plugins
from end_effector_hal.signals import Frame, Kind
from end_effector_hal.vocabulary import MOST_CHANNELS

LONGEST_PERIOD_US = 600_000_000
_CHANNEL = re.compile(r"[a-z][a-z0-9_]{0,39}")
_RESERVED = "none"
"""A description uses this word where there is no channel."""


class DeclaredCodec:
    """A codec with checked and fixed declarations: they can no longer change or fail. Its methods are those of the
    codec.

    Args:
        codec: possibly third-party; reading its attributes may raise any exception.

    Raises:
        UsageError: a declaration does not match `Codec`.
    """

    def __init__(self, codec: Codec) -> None:
        self._codec = codec
        self.name = codec.name
        self.channels: Mapping[str, Kind] = dict(codec.channels)
        self.period_us, self.baudrate = codec.period_us, codec.baudrate
        self.parity = getattr(codec, "parity", "N")
        self.resolution_pa = getattr(codec, "resolution_pa", 1)
        if wrong := next(self._wrong(), ""):
            raise UsageError(
                f"the codec declares {wrong}.", todo="Its author's tests inherit CodecConformance."
            )

    def decoder(self) -> Decoder:
        """Return a new decoder for one stream."""
        return self._codec.decoder()

    def encode(self, frame: Frame) -> bytes:
        """Return the bytes of a frame."""
        return self._codec.encode(frame)

    def _wrong(self) -> Iterator[str]:
        if type(self.name) is not str or not 0 < len(self.name) <= 64 or not self.name.isprintable():
            yield "an invalid name"
        if not 0 < len(self.channels) <= MOST_CHANNELS:
            yield f"{len(self.channels)} channels, expected 1 to {MOST_CHANNELS}"
        for channel, kind in self.channels.items():
            if type(channel) is not str or not _CHANNEL.fullmatch(channel) or channel == _RESERVED:
                yield "an invalid channel name: use lower-case letters, digits and '_', a letter first, not 'none'"
            if not isinstance(kind, Kind):
                yield f"no Kind for the channel {channel}"
        yield from self._number("period_us", 1, LONGEST_PERIOD_US)
        yield from self._number("baudrate", 300, 4_000_000)
        if self.parity not in ("N", "E", "O"):
            yield "a parity that is not N, E or O"
        if type(self.resolution_pa) not in (int, float) or not 0 < self.resolution_pa < 1e9:
            yield "a resolution_pa that is no number above 0"

    def _number(self, key: str, least: int, most: int) -> Iterator[str]:
        value = getattr(self, key)
        if type(value) is not int or not least <= value <= most:
            yield f"a {key} that is no whole number from {least} to {most}"


class DeclaredPolledCodec(DeclaredCodec):
    """A polled codec with checked and fixed declarations."""

    _codec: PolledCodec
    decoder: Callable[[], PolledDecoder]

    def device(self) -> Device:
        """Return a new simulated device for one stream."""
        return self._codec.device()


def declared(codec: Codec) -> Codec:
    """Return the codec with checked and fixed declarations; raises UsageError, or any exception of the codec itself."""
    return DeclaredPolledCodec(codec) if is_polled(codec) else DeclaredCodec(codec)


GROUP = "end_effector_hal.codecs"
OWN = {
    "ees1-ascii": "end_effector_hal.codecs:Ees1Ascii",
    "ees1-cobs": "end_effector_hal.codecs:Ees1Cobs",
    "legacy-nibble": "end_effector_hal.codecs:LegacyNibble",
    "modbus-rtu-epick": "end_effector_hal.codecs.modbus:EPick",
    "modbus-rtu-onrobot-vg": "end_effector_hal.codecs.modbus:OnRobotVG",
    "modbus-rtu-transmitters": "end_effector_hal.codecs.modbus:Transmitters",
}
_PARTS = ("name", "channels", "period_us", "baudrate", "decoder", "encode")


def codec_names() -> tuple[str, ...]:
    """Return all names that `get_codec` accepts, the built-in ones first."""
    return _CODECS.names


def get_codec(name: str) -> Codec:
    """Return the codec of this name.

    Other distributions add codecs with an entry point (a class or an object) in ``end_effector_hal.codecs``.

    Raises:
        UsageError: there is none of that name (did you mean …), or it cannot be loaded.
    """
    return _CODECS.get(name)


def _checked(codec: Any) -> Codec:
    if missing := [part for part in _PARTS if not hasattr(codec, part)]:
        raise UsageError(
            f"this is not a codec: it has no {', '.join(missing)}.",
            todo="Inherit end_effector_hal.codecs.conformance.CodecConformance in its tests.",
        )
    return declared(codec)


_CODECS: Plugins[Codec] = Plugins(GROUP, "codec", OWN, _checked)
