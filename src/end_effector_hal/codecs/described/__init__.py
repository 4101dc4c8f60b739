"""Codecs that a description declares: `link: {frame: …}` with `channels`, instead of the name of a codec."""

from ._checksum import CHECKSUMS
from ._codec import DescribedCodec
from ._described import described_codec
