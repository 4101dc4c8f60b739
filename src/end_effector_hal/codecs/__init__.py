"""Codecs: the formats of frames on a wire. `get_codec` returns one by its name.

A codec of your own is one class (see `Codec`; `PolledCodec` if the device has to be polled), an entry point in the
group ``end_effector_hal.codecs``, and a test that inherits `CodecConformance` or `PolledCodecConformance` of
`end_effector_hal.codecs.conformance`. Modbus devices need no class: see `end_effector_hal.codecs.modbus`.
"""

from ._answers import Counters, counters_of, frame_fault
from ._carrier import (
    FrameSource,
    board_inputs,
    carrier_of,
    codec_of,
    line_of,
    line_words,
    period_of,
    sources_of,
)
from ._codec import (
    Carrier,
    Codec,
    Decoder,
    Device,
    Polled,
    PolledCodec,
    PolledDecoder,
    Sequence,
    asks,
    is_polled,
    parity_of,
    shows_noise,
)
from ._ees1 import Ees1Ascii, Ees1AsciiDecoder, Ees1Cobs, Ees1CobsDecoder
from ._legacy_nibble import LegacyNibble, LegacyNibbleDecoder
from ._match import load_tool, match_codec
from ._registry import codec_names, declared, get_codec

OWN_DECODERS = (Ees1AsciiDecoder, Ees1CobsDecoder, LegacyNibbleDecoder)
"""The decoders of the built-in codecs, whose frames need no check."""

__all__ = [
    "OWN_DECODERS",
    "Carrier",
    "Codec",
    "Counters",
    "Decoder",
    "Device",
    "Ees1Ascii",
    "Ees1Cobs",
    "FrameSource",
    "LegacyNibble",
    "Polled",
    "PolledCodec",
    "PolledDecoder",
    "Sequence",
    "asks",
    "board_inputs",
    "carrier_of",
    "codec_names",
    "codec_of",
    "counters_of",
    "declared",
    "frame_fault",
    "get_codec",
    "is_polled",
    "line_of",
    "line_words",
    "load_tool",
    "match_codec",
    "parity_of",
    "period_of",
    "shows_noise",
    "sources_of",
]
