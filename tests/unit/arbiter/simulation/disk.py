"""A disk in virtual time: it may be full, fail, write less than it was given, and lose what was not synced."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable


class SimulatedDisk:
    """A `Storage` of one file.

    Args:
        hazard: called in the middle of everything that touches the disk; it may not return.
    """

    def __init__(self, name: str, hazard: Callable[[str], None]) -> None:
        self._name, self._hazard = name, hazard
        self.content = bytearray()
        self.safe = b""
        """What a loss of power leaves."""
        self.full = self.failing = False
        self.hangs = False

    def read(self) -> bytes:
        """Everything."""
        self._check(0)
        return bytes(self.content)

    def create(self, content: bytes, size: int) -> None:
        """A new file in one step."""
        self._check(size)
        self._hazard(f"{self._name} create")
        self.content = bytearray(content.ljust(size, b"\0"))
        self.safe = bytes(self.content)

    def write(self, at: int, data: bytes) -> None:
        """In place; whoever dies in it leaves a part."""
        self._check(0)
        if not self.content:
            raise OSError(errno.ENOENT, os.strerror(errno.ENOENT))
        half = len(data) // 2
        self._put(at, data[:half])
        self._hazard(f"{self._name} write")
        self._put(at + half, data[half:])

    def sync(self) -> None:
        """Make it safe."""
        self._hazard(f"{self._name} sync")
        self._check(0)
        self.safe = bytes(self.content)

    def remove(self) -> None:
        """Delete the file; possible also on a disk that is full."""
        self.content = bytearray()

    def close(self) -> None:
        """Nothing to do."""

    def lose_power(self) -> None:
        """What was not synced is lost."""
        self.content = bytearray(self.safe)

    def _put(self, at: int, data: bytes) -> None:
        self.content[at : at + len(data)] = data

    def _check(self, room: int) -> None:
        if self.failing:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        if room and self.full:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
