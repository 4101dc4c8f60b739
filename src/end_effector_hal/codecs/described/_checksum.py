"""Checksums of declared frames, by their names in a description."""

from __future__ import annotations

import zlib
from binascii import crc_hqx
from collections.abc import Callable
from functools import cache, reduce
from operator import xor
from typing import NamedTuple


class Checksum(NamedTuple):
    """The size of a checksum in bytes, and the function that computes it."""

    size: int
    of: Callable[[bytes], int]


@cache
def _table(polynomial: int, width: int, *, reflected: bool) -> tuple[int, ...]:
    """Return the table of a CRC of this width: the entry of each byte."""
    top, mask = 1 << (width - 1), (1 << width) - 1

    def entry(byte: int) -> int:
        value = byte if reflected else byte << (width - 8)
        for _ in range(8):
            if reflected:
                value = value >> 1 ^ (polynomial if value & 1 else 0)
            else:
                value = (value << 1 ^ (polynomial if value & top else 0)) & mask
        return value

    return tuple(map(entry, range(256)))


def _crc8(data: bytes) -> int:
    table = _table(0x07, 8, reflected=False)
    return reduce(lambda crc, byte: table[crc ^ byte], data, 0)


def _crc16_modbus(data: bytes) -> int:
    table = _table(0xA001, 16, reflected=True)
    return reduce(lambda crc, byte: crc >> 8 ^ table[(crc ^ byte) & 0xFF], data, 0xFFFF)


CHECKSUMS: dict[str, Checksum] = {
    "none": Checksum(0, lambda data: 0),
    "xor8": Checksum(1, lambda data: reduce(xor, data, 0)),
    "sum8": Checksum(1, lambda data: sum(data) & 0xFF),
    "crc8": Checksum(1, _crc8),
    "crc16-modbus": Checksum(2, _crc16_modbus),
    "crc16-ccitt": Checksum(2, lambda data: crc_hqx(data, 0xFFFF)),
    "crc32": Checksum(4, zlib.crc32),
}
"""The checksums by name; crc8 is that of SMBus (07, from 0), crc16-ccitt is CRC-16/CCITT-FALSE (from FFFF),
crc32 that of zlib.
"""
