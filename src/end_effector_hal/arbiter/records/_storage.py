"""A file of fixed size whose space is allocated at creation, so that a later write cannot fail for lack of space."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Protocol

from end_effector_hal.owned import open_owned

MOST = 1 << 20
"""Most bytes of a file that are read."""


class Storage(Protocol):
    """Storage that outlives the process; every method may raise OSError. `FileStorage` documents the methods."""

    def read(self) -> bytes:
        """Return the whole content; empty if there is none yet."""
        ...

    def create(self, content: bytes, size: int) -> None:
        """Replace the whole content by these bytes in one step, and allocate ``size`` bytes."""
        ...

    def write(self, at: int, data: bytes) -> None:
        """Overwrite the bytes from offset ``at`` on."""
        ...

    def sync(self) -> None:
        """Return once the content would survive a power loss."""
        ...

    def remove(self) -> None:
        """Delete the content."""
        ...

    def close(self) -> None:
        """Release the storage."""
        ...


class FileStorage:
    """A file that outlives the process; every method may raise OSError. Links and other users' files are refused.

    Args:
        path: the file; its folder exists.
        durable: whether a new file survives a power loss; if not, no call waits for a disk.
    """

    def __init__(self, path: Path, *, durable: bool) -> None:
        self._path, self._durable = path, durable
        self._fd = -1

    def read(self) -> bytes:
        """Return the whole content; empty if there is no file yet."""
        try:
            fd = self._opened()
        except FileNotFoundError:
            return b""
        content = b""
        while len(content) < MOST and (part := os.pread(fd, MOST - len(content), len(content))):
            content += part
        return content

    def create(self, content: bytes, size: int) -> None:
        """Create a new file of ``size`` bytes in one step: a power loss leaves either the old file or the new one."""
        self.close()
        fresh = self._path.with_name(f".{self._path.name}.new")
        fresh.unlink(missing_ok=True)
        self._fd = open_owned(fresh, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o640)
        try:
            os.posix_fallocate(self._fd, 0, size)
            self.write(0, content)
            if self._durable:
                os.fsync(self._fd)
            fresh.replace(self._path)
        except BaseException:
            self.close()
            fresh.unlink(missing_ok=True)
            raise
        if self._durable:
            self._sync_folder()

    def write(self, at: int, data: bytes) -> None:
        """Overwrite allocated bytes from offset ``at`` on. After an error some of them may be written."""
        fd = self._fd if self._fd >= 0 else self._opened()
        while data:  # one call may write only some of them
            written = os.pwrite(fd, data, at)
            if not written:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            at, data = at + written, data[written:]

    def sync(self) -> None:
        """Return once the content would survive a power loss."""
        os.fdatasync(self._opened())

    def remove(self) -> None:
        """Delete the file."""
        self.close()
        self._path.unlink(missing_ok=True)

    def close(self) -> None:
        """Close the file; the next call opens it again."""
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1

    def _sync_folder(self) -> None:
        folder = os.open(self._path.parent, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)

    def _opened(self) -> int:
        if self._fd < 0:
            self._fd = open_owned(self._path, os.O_RDWR)
        return self._fd
