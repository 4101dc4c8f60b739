"""Codecs that a description declares: `link: {frame: …}` with `channels`, instead of the name of a codec."""

from ._field import CHECKSUMS
