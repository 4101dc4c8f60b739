"""A split virtqueue, seen from the device (virtio 1.2, section 2.7)."""

from __future__ import annotations

import struct
from collections.abc import Callable

from end_effector_hal.errors import WireError

from ._memory import GuestMemory, Place

_DESCRIPTOR = struct.Struct("<QIHH")
_USED = struct.Struct("<II")
_INDEX = struct.Struct("<H")
_NEXT, _WRITE = 1, 2


class Virtqueue:
    """Takes chains that the driver has made available, and gives them back with an answer.

    Args:
        memory: of the guest.
        size: number of descriptors.
        descriptors: where their table stands.
        available: where the ring of the driver stands.
        used: where the ring of the device stands.
        seen: index of the first chain that was not taken yet.
    """

    def __init__(
        self, memory: GuestMemory, size: int, descriptors: Place, available: Place, used: Place, seen: int = 0
    ) -> None:
        self._memory, self._size = memory, size
        self._descriptors, self._available, self._used = descriptors, available, used
        self.seen = seen

    def serve(self, answer: Callable[[bytes], bytes]) -> int:
        """Answer every chain that waits; how many there were. Raises WireError for a queue that is broken."""
        served = 0
        while _read(self._available, 2) != self.seen:
            head = _read(self._available, 4 + 2 * (self.seen % self._size))
            request, room = self._chain(head)
            written = self._fill(room, answer(request))
            position = _read(self._used, 2)
            _USED.pack_into(
                self._used.memory,
                self._used.offset + 4 + _USED.size * (position % self._size),
                head,
                written,
            )
            _write(self._used, 2, position + 1)  # last: now it is the driver's
            self.seen = (self.seen + 1) & 0xFFFF
            served += 1
        return served

    def _chain(self, number: int) -> tuple[bytes, list[tuple[Place, int]]]:
        """What the driver says, and where the answer goes."""
        said, room = bytearray(), []
        for _ in range(self._size):
            if number >= self._size:
                break
            table, offset = self._descriptors
            address, length, flags, after = _DESCRIPTOR.unpack_from(table, offset + _DESCRIPTOR.size * number)
            memory, start = place = self._memory.at_guest(address)
            if flags & _WRITE:
                room.append((place, length))
            else:
                said += memory[start : start + length]
            if not flags & _NEXT:
                return bytes(said), room
            number = after
        raise WireError("a virtqueue of the guest is broken.")

    @staticmethod
    def _fill(room: list[tuple[Place, int]], data: bytes) -> int:
        written = 0
        for (memory, start), length in room:
            part = data[written : written + length]
            memory[start : start + len(part)] = part
            written += len(part)
        return written


def _read(place: Place, at: int) -> int:
    return int(_INDEX.unpack_from(place.memory, place.offset + at)[0])


def _write(place: Place, at: int, value: int) -> None:
    _INDEX.pack_into(place.memory, place.offset + at, value & 0xFFFF)
