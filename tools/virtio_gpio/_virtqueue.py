"""The guest's memory, shared with this process, and the device side of a split virtqueue (section 2.7)."""

from __future__ import annotations

import mmap
import os
import struct
from collections.abc import Callable, Sequence
from typing import NamedTuple

from end_effector_hal.errors import WireError

_REGION = struct.Struct("<QQQQ")


class Place(NamedTuple):
    """An offset in a mapping."""

    memory: mmap.mmap
    offset: int


class _Region(NamedTuple):
    guest: int
    user: int
    size: int
    memory: mmap.mmap
    offset: int


class GuestMemory:
    """Memory regions that the front-end shares (VHOST_USER_SET_MEM_TABLE).

    Args:
        table: the payload of the message.
        fds: a file for each region; closed here.

    Raises:
        WireError: the memory cannot be mapped.
    """

    def __init__(self, table: bytes = b"", fds: Sequence[int] = ()) -> None:
        self._regions: list[_Region] = []
        try:
            for number, fd in enumerate(fds):
                guest, size, user, offset = _REGION.unpack_from(table, 8 + _REGION.size * number)
                self._regions.append(_Region(guest, user, size, mmap.mmap(fd, size + offset), offset))
        except (OSError, ValueError, struct.error) as error:
            self.close()
            raise WireError(f"the memory of the guest cannot be mapped: {error}.") from error
        finally:
            for fd in fds:
                os.close(fd)

    def at_guest(self, address: int) -> Place:
        """Return the place of a guest-physical address; raises WireError."""
        for region in self._regions:
            if region.guest <= address < region.guest + region.size:
                return Place(region.memory, address - region.guest + region.offset)
        raise WireError(f"the guest has no memory at {address:#x}.")

    def at_user(self, address: int) -> Place:
        """Return the place of an address of the front-end's process; raises WireError."""
        for region in self._regions:
            if region.user <= address < region.user + region.size:
                return Place(region.memory, address - region.user + region.offset)
        raise WireError(f"the front-end has shared no memory at {address:#x}.")

    def close(self) -> None:
        while self._regions:
            self._regions.pop().memory.close()


_DESCRIPTOR = struct.Struct("<QIHH")
_USED = struct.Struct("<II")
_INDEX = struct.Struct("<H")
_NEXT, _WRITE = 1, 2


class Virtqueue:
    """Reads descriptor chains that the driver has made available, and returns them with an answer.

    Args:
        memory: memory of the guest.
        size: number of descriptors.
        descriptors: place of the descriptor table.
        available: place of the driver's ring.
        used: place of the device's ring.
        seen: index of the first unread chain.
    """

    def __init__(
        self, memory: GuestMemory, size: int, descriptors: Place, available: Place, used: Place, seen: int = 0
    ) -> None:
        self._memory, self._size = memory, size
        self._descriptors, self._available, self._used = descriptors, available, used
        self.seen = seen

    def serve(self, answer: Callable[[bytes], bytes]) -> int:
        """Answer all pending chains and return their number; raises WireError for a broken queue."""
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
        """Return the driver's request, and the buffers for the answer."""
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
