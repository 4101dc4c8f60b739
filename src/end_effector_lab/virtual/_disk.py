"""A disk in virtual time: it may be full, fail, or hang, and a loss of power discards data that was not synced."""

from __future__ import annotations

import errno
import os


class VirtualDisk:
    """A `Storage`: the bytes of one file.

    Attributes:
        content: the bytes that a process reads.
        safe: the bytes that survive a loss of power.
        full: no room for a new file.
        fails: every access raises an I/O error.
        hangs: a read at the start and every write never end.
    """

    def __init__(self) -> None:
        self.content = bytearray()
        self.safe = b""
        self.full = self.fails = self.hangs = False

    def read(self) -> bytes:
        """Return the whole content."""
        self._check(0)
        return bytes(self.content)

    def create(self, content: bytes, size: int) -> None:
        """Create a new file in one step; it survives a loss of power."""
        self._check(size)
        self.content = bytearray(content.ljust(size, b"\0"))
        self.sync()

    def write(self, at: int, data: bytes) -> None:
        """Overwrite bytes in place."""
        self._check(0)
        if not self.content:
            raise OSError(errno.ENOENT, os.strerror(errno.ENOENT))
        self.content[at : at + len(data)] = data

    def sync(self) -> None:
        """Make the content safe against a loss of power."""
        self._check(0)
        self.safe = bytes(self.content)

    def remove(self) -> None:
        """Delete the file; this works on a full disk as well."""
        self.content = bytearray()

    def close(self) -> None:
        """Do nothing, since nothing is open."""

    def lose_power(self) -> None:
        """Discard the content that was not synced."""
        self.content = bytearray(self.safe)

    def _check(self, room: int) -> None:
        if self.fails:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        if room and self.full:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
