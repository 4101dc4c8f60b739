"""A disk in virtual time: it may be full, fail, or hang, and it loses what was not synced with the power."""

from __future__ import annotations

import errno
import os


class VirtualDisk:
    """A `Storage`: the bytes of one file.

    Attributes:
        content: what a process reads.
        safe: what a loss of power leaves.
        full: there is no room for a new file.
        fails: every access is an error of input and output.
        hangs: nothing that is read at a start or written comes to an end.
    """

    def __init__(self) -> None:
        self.content = bytearray()
        self.safe = b""
        self.full = self.fails = self.hangs = False

    def read(self) -> bytes:
        """Everything."""
        self._check(0)
        return bytes(self.content)

    def create(self, content: bytes, size: int) -> None:
        """A new file in one step, which also survives a loss of power."""
        self._check(size)
        self.content = bytearray(content.ljust(size, b"\0"))
        self.sync()

    def write(self, at: int, data: bytes) -> None:
        """In place."""
        self._check(0)
        if not self.content:
            raise OSError(errno.ENOENT, os.strerror(errno.ENOENT))
        self.content[at : at + len(data)] = data

    def sync(self) -> None:
        """Make it safe."""
        self._check(0)
        self.safe = bytes(self.content)

    def remove(self) -> None:
        """Delete the file; possible also on a disk that is full."""
        self.content = bytearray()

    def close(self) -> None:
        """Nothing is open."""

    def lose_power(self) -> None:
        """What was not synced is lost."""
        self.content = bytearray(self.safe)

    def _check(self, room: int) -> None:
        if self.fails:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        if room and self.full:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
