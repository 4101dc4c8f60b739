"""Codecs: how frames stand on a wire. One is found by its name with `get_codec`.

A codec of your own is one class (see `Codec`), an entry point in the group ``end_effector_hal.codecs``, and a
test that inherits `end_effector_hal.wires.codecs.conformance.CodecConformance`.
"""

from end_effector_hal.wires.codecs._codec import Codec, Decoder
from end_effector_hal.wires.codecs._ees1_ascii import Ees1Ascii
from end_effector_hal.wires.codecs._legacy_nibble import LegacyNibble
from end_effector_hal.wires.codecs._registry import codec_names, get_codec
from end_effector_hal.wires.codecs._sequence import Sequence

__all__ = ["Codec", "Decoder", "Ees1Ascii", "LegacyNibble", "Sequence", "codec_names", "get_codec"]
