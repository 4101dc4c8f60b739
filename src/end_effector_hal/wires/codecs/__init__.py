"""Codecs: how frames stand on a wire. One is found by its name with `get_codec`.

A codec of your own is one class (see `Codec`; `PolledCodec` where the device has to be asked), an entry point in
the group ``end_effector_hal.codecs``, and a test that inherits `CodecConformance` or `PolledCodecConformance` of
`end_effector_hal.wires.codecs.conformance`. Modbus devices need no class: see `end_effector_hal.wires.codecs.modbus`.
"""

from end_effector_hal.wires.codecs._codec import Codec, Decoder, parity_of, resolution_of, shows_noise
from end_effector_hal.wires.codecs._declared import declared
from end_effector_hal.wires.codecs._ees1_ascii import Ees1Ascii
from end_effector_hal.wires.codecs._ees1_cobs import Ees1Cobs
from end_effector_hal.wires.codecs._legacy_nibble import LegacyNibble
from end_effector_hal.wires.codecs._named import named
from end_effector_hal.wires.codecs._polled import (
    Device,
    Polled,
    PolledCodec,
    PolledDecoder,
    asks,
    is_polled,
)
from end_effector_hal.wires.codecs._registry import codec_names, codec_of, get_codec
from end_effector_hal.wires.codecs._sequence import Sequence, sequence_of

__all__ = [
    "Codec",
    "Decoder",
    "Device",
    "Ees1Ascii",
    "Ees1Cobs",
    "LegacyNibble",
    "Polled",
    "PolledCodec",
    "PolledDecoder",
    "Sequence",
    "asks",
    "codec_names",
    "codec_of",
    "declared",
    "get_codec",
    "is_polled",
    "named",
    "parity_of",
    "resolution_of",
    "sequence_of",
    "shows_noise",
]
