"""What a frame and a decoder of somebody else's may be."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping

from end_effector_hal.signals import Frame, Kind

HIGHEST_PA = 2**31 - 1
HIGHEST_CLOCK = 2**63 - 1
_BYTES = (bytes, bytearray, str)
_MANY = (list, tuple, set, frozenset, deque)


def checked(frame: object, kinds: Mapping[str, Kind], last: int, now: int) -> str:
    """What is wrong with a frame, as the end of a sentence; empty: nothing.

    Args:
        frame: as it was returned.
        kinds: of the codec's channels.
        last: µs, stamp of the frame before it.
        now: µs.
    """
    if type(frame) is not Frame:
        return "something else than frames"
    if type(frame.at) is not int or not last <= frame.at <= now:
        return "a frame whose stamp is ahead of now, before the last one, or no time"
    if not _counts(frame.seq, HIGHEST_PA) or not _counts(frame.device_ms, HIGHEST_CLOCK):
        return "a frame whose number or clock is no whole number in its range"
    for channel, value in frame.values.items():
        kind = kinds.get(channel) if type(channel) is str else None
        if kind is None:
            return "a frame with a channel that the codec does not declare"
        if value is None:
            continue
        if kind is Kind.BIT and type(value) is not bool:
            return f"a frame whose bit {channel} is neither true nor false"
        if kind is Kind.PRESSURE and (type(value) is not int or abs(value) > HIGHEST_PA):
            return f"a frame whose pressure {channel} is no whole number of Pa"
    return ""


def weight(decoder: object, codec: object = None) -> int:
    """Bytes and elements in the attributes of a decoder and of its own objects, without those of its codec."""
    return sum(map(_weight, _parts(decoder, {id(codec), id(decoder)}, depth=3)))


def _parts(owner: object, seen: set[int], depth: int) -> Iterator[object]:
    names = [*getattr(owner, "__dict__", ())]
    for kind in type(owner).__mro__:
        slots = vars(kind).get("__slots__", ())
        names += [slots] if isinstance(slots, str) else [*slots]
    for name in names:
        part = getattr(owner, name, None)
        if id(part) in seen or isinstance(part, type):
            continue
        seen.add(id(part))
        yield part
        if depth and (hasattr(part, "__dict__") or hasattr(part, "__slots__")):
            yield from _parts(part, seen, depth - 1)


def _weight(part: object) -> int:
    if isinstance(part, _BYTES):
        return len(part)
    if isinstance(part, dict):
        return len(part) + sum(len(each) for each in part.values() if isinstance(each, (*_BYTES, *_MANY)))
    if isinstance(part, _MANY):
        return len(part) + sum(len(each) for each in part if isinstance(each, _BYTES))
    return 0


def _counts(value: object, highest: int) -> bool:
    return value is None or (type(value) is int and 0 <= value <= highest)
