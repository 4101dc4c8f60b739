"""Unpacking the chunks of a bag: a few bytes may claim to be gigabytes, so that there is a limit."""

from __future__ import annotations

from bz2 import BZ2Decompressor
from io import BytesIO

UNPACKED_BYTES = 64 * 2**20
"""Of one chunk. Recorders of ROS begin a new one after 4 MB at most; one message may be longer, such as a picture."""


def unpack(compression: str, data: bytes) -> bytes:
    """The content of a chunk.

    Args:
        compression: ``zstd``, ``lz4``, ``bz2``, or ``none`` or nothing.
        data: as it stands in the file.

    Raises:
        ValueError: it unpacks to more than `UNPACKED_BYTES`, is cut off, or the compression is not known.
        Exception: what a decompressor raises for bytes that are not its own.
    """
    if compression in ("", "none"):
        return data
    if compression == "zstd":
        from zstandard import ZstdDecompressor

        # not .decompress(): that reserves what the data claim, whatever limit it is given
        with ZstdDecompressor().stream_reader(BytesIO(data)) as stream:
            found, ended = stream.read(UNPACKED_BYTES + 1), True  # its caller compares the length
    elif compression == "lz4":
        from lz4.frame import LZ4FrameDecompressor

        lz4 = LZ4FrameDecompressor()
        found, ended = lz4.decompress(data, max_length=UNPACKED_BYTES + 1), lz4.eof
    elif compression == "bz2":
        bz2 = BZ2Decompressor()
        found, ended = bz2.decompress(data, max_length=UNPACKED_BYTES + 1), bz2.eof
    else:
        raise ValueError(f"the compression {compression!r} is not known")
    if len(found) > UNPACKED_BYTES:
        raise ValueError(f"it unpacks to more than {UNPACKED_BYTES // 2**20} MiB")
    if not ended:
        raise ValueError("its compressed data are cut off")
    return found
