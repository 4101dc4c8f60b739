"""The guest's memory, shared with this process."""

from __future__ import annotations

import mmap
import os
import struct
from collections.abc import Sequence
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
    """Regions of memory as the front-end describes them (VHOST_USER_SET_MEM_TABLE).

    Args:
        table: the payload of the message.
        fds: a file for each region; closed here.

    Raises:
        WireError: it cannot be mapped.
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
        """Where a guest-physical address stands; raises WireError."""
        for region in self._regions:
            if region.guest <= address < region.guest + region.size:
                return Place(region.memory, address - region.guest + region.offset)
        raise WireError(f"the guest has no memory at {address:#x}.")

    def at_user(self, address: int) -> Place:
        """Where an address of the front-end's process stands; raises WireError."""
        for region in self._regions:
            if region.user <= address < region.user + region.size:
                return Place(region.memory, address - region.user + region.offset)
        raise WireError(f"the front-end has shared no memory at {address:#x}.")

    def close(self) -> None:
        """Forget it."""
        while self._regions:
            self._regions.pop().memory.close()
