"""A disk that is full for a while, for the files of a recording."""

from __future__ import annotations

import errno
import os


class FullDisk:
    """``os`` of the writer, without room while ``full``."""

    full = False

    def __getattr__(self, name: str) -> object:
        return self.write if name == "write" else getattr(os, name)

    def write(self, fd: int, data: bytes) -> int:
        if self.full:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return os.write(fd, data)
