"""Consistent overhead byte stuffing (Cheshire and Baker, 1999): bytes without a zero among them."""

from __future__ import annotations

BLOCK = 254  # the longest run without a zero that one code byte can announce


def stuff(data: bytes) -> bytes:
    """The same without zeros; one byte longer for each 254 bytes begun."""
    out = bytearray()
    for part in data.split(b"\0"):
        while len(part) >= BLOCK:
            out += b"\xff" + part[:BLOCK]
            part = part[BLOCK:]
        out += bytes([len(part) + 1]) + part
    return bytes(out)


def unstuff(data: bytes) -> bytes | None:
    """What was stuffed; None if this is nothing that `stuff` makes."""
    out, at = bytearray(), 0
    while at < len(data):
        code = data[at]
        end = at + code
        if code == 0 or end > len(data):
            return None
        out += data[at + 1 : end]
        at = end
        if code <= BLOCK and at < len(data):
            out.append(0)
    return bytes(out)
