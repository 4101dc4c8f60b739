"""Codecs that a description declares: `link: {frame: …}` with `channels`, instead of the name of a codec."""

from ._described import described_codec

__all__ = ["described_codec"]
