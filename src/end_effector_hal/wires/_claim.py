"""An exclusive claim that ends with its process and names its holder."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

from end_effector_hal.errors import LineBusyError, WireError
from end_effector_hal.owned import open_owned
from end_effector_hal.vocabulary import printable
from end_effector_hal.wires._processes import program_name


class Claim:
    """A lock (flock) on a side file that contains the pid and the program of the holder.

    Args:
        path: the side file; it is never deleted, because only the lock counts.
        what: the thing that is claimed, for the error.
        fd: descriptor of an inherited claim on the same file, which is already locked.

    Raises:
        LineBusyError: another process has the claim.
        WireError: the file cannot be written.
    """

    def __init__(self, path: str | Path, what: str, *, fd: int = -1) -> None:
        import fcntl  # what needs no wires needs no POSIX

        try:
            self._fd = fd if fd >= 0 else open_owned(path, os.O_RDWR | os.O_CREAT, 0o660)
        except OSError as error:
            raise WireError(
                f"{what} cannot be claimed: {error.strerror}.",
                where=str(path),
                todo="Remove it, or give a path in a directory that exists and that only this user can write.",
            ) from error
        try:
            fcntl.flock(self._fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            holder = (
                printable(os.pread(self._fd, 200, 0).decode(errors="replace").strip()) or "another process"
            )
            os.close(self._fd)
            raise LineBusyError(
                f"{what} is held by {holder}.",
                where=str(path),
                todo="Stop that process, or wait for its end.",
            ) from error
        with suppress(OSError):  # for people only: a full disk is no reason not to have it
            os.ftruncate(self._fd, 0)
            os.pwrite(self._fd, f"pid {os.getpid()} ({program_name()})\n".encode(), 0)

    @property
    def fd(self) -> int:
        """The descriptor of the claim; a copy of it keeps the claim."""
        return self._fd

    def release(self) -> None:
        """Release the claim; a second call has no effect."""
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1
