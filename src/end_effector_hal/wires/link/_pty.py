"""A pair of pseudo terminals, which acts as a serial cable on one machine."""

from __future__ import annotations

import os
from pathlib import Path

from end_effector_hal.errors import LineBusyError, LinkBusyError, LinkError, WireError
from end_effector_hal.wires._claim import Claim


class PtyPair:
    """Keeps the master end; the slave end gets a chosen name, for ``port:`` in a description.

    Like a UART, the pair does not wait for a reader: data that finds the buffer full is lost. The slave is kept open
    here, so that readers may open and close it.

    Args:
        link: path of the symbolic link to the slave; one that was left behind is replaced.

    Raises:
        LinkBusyError: another pair uses this path; the message names its process.
        LinkError: the pair cannot be created.
    """

    def __init__(self, link: str | Path) -> None:
        import tty  # what needs no wires needs no POSIX

        self.link = Path(link)
        self._claim = _claim(self.link)
        self.master, self._slave = os.openpty()
        tty.setraw(self._slave)
        os.fchown(self._slave, -1, os.getegid())
        os.fchmod(self._slave, 0o660)  # as a port: a service of another user reads it
        os.set_blocking(self.master, False)
        self.slave_name = os.ttyname(self._slave)
        try:
            if self.link.exists() and not self.link.is_symlink():
                raise FileExistsError(0, "there is a file of that name")
            fresh = self.link.with_name(f".{self.link.name}.{os.getpid()}")
            fresh.symlink_to(self.slave_name)
            fresh.replace(self.link)
        except OSError as error:
            self._close_ends()
            raise LinkError(
                f"the pseudo-terminal cannot be linked: {error.strerror}.",
                where=str(link),
                todo="Give another path.",
            ) from error

    def write(self, data: bytes) -> int:
        """Send data; return the number of bytes that found room."""
        try:
            return os.write(self.master, data)
        except BlockingIOError:
            return 0

    def read(self, most: int = 4096) -> bytes:
        """Return the data that the other end has sent; b"" if there is none."""
        try:
            return os.read(self.master, most)
        except BlockingIOError:
            return b""

    def fileno(self) -> int:
        """Return the descriptor of the master, for select."""
        return self.master

    def close(self) -> None:
        """Close both ends; a reader gets an end of file. The link is removed unless another pair has replaced it."""
        if self.master < 0:
            return
        if self.link.is_symlink() and os.readlink(self.link) == self.slave_name:
            self.link.unlink(missing_ok=True)
        self._close_ends()

    def __enter__(self) -> PtyPair:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _close_ends(self) -> None:
        os.close(self.master)
        os.close(self._slave)
        self.master = -1
        if self._claim:
            self._claim.release()


def _claim(link: Path) -> Claim | None:
    try:
        return Claim(f"{link}.lock", "the port")
    except LineBusyError as error:
        raise LinkBusyError(
            error.what, where=str(link), todo="Stop that process, or give another port."
        ) from error
    except WireError:
        return None  # no place for a side file is none for a link either: that one says why
