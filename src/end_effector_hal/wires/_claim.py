"""Exclusive claims on files and ports, and the names of the processes that hold them.

A claim ends with its process. Other processes are only read: nothing is sent to them.
"""

from __future__ import annotations

import glob
import os
import socket
from collections.abc import Iterable, Iterator
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

from end_effector_hal.errors import LineBusyError, LinkBusyError, WireError
from end_effector_hal.owned import open_owned
from end_effector_hal.vocabulary import printable

_PTMX = ("/dev/ptmx", "/dev/pts/ptmx")
_LINE_REQUEST = "anon_inode:gpio-line"
"""Name that the kernel gives to the descriptor of a request for lines."""


class Holder(NamedTuple):
    """A process and its command line."""

    pid: int
    program: str

    def __str__(self) -> str:
        return f"pid {self.pid} ({self.program})"


def holders_of(path: str | Path, *, own: bool = False) -> list[Holder]:
    """Return the processes that have a file open or locked, as far as this user may see them; [] if the file does not
    exist.

    The process at the master end of a pty is left out: it is the cable. ``own``: include this process.
    """
    device = os.path.realpath(path)
    found = lockers_of(device)
    ends: set[int] = set()
    for pid, link, target in _open_files():
        if target == device:
            found.add(pid)
        elif target in _PTMX and device == f"/dev/pts/{_tty_index(link)}":
            ends.add(pid)
    return _called(found - ends - (set() if own else {os.getpid()}))


def holders_of_lines(proc: str = "/proc") -> list[Holder]:
    """Return the processes that have requested lines of any GPIO chip, as far as this user may see them."""
    return _called({pid for pid, _, target in _open_files(proc) if target.startswith(_LINE_REQUEST)})


def _called(pids: Iterable[int]) -> list[Holder]:
    return [Holder(pid, program_name(pid)) for pid in sorted(pids)]


def _open_files(proc: str = "/proc") -> Iterator[tuple[int, str, str]]:
    for link in glob.iglob(f"{proc}/[0-9]*/fd/*"):
        try:
            yield int(link.split("/")[-3]), link, os.readlink(link)
        except OSError:
            continue


def _tty_index(link: str) -> str:
    """Return the number of the slave that belongs to a pty's master; "" if it is unknown."""
    try:
        text = Path(link.replace("/fd/", "/fdinfo/")).read_text(encoding="ascii")
    except OSError:
        return ""
    return next((line.split()[1] for line in text.splitlines() if line.startswith("tty-index:")), "")


def lockers_of(path: str | Path) -> set[int]:
    """Return the processes that hold a flock(2) on a file, of all users, from the kernel's list."""
    try:
        status, locks = os.stat(path), Path("/proc/locks").read_text(encoding="ascii")
    except OSError:
        return set()
    key = f"{os.major(status.st_dev):02x}:{os.minor(status.st_dev):02x}:{status.st_ino}"
    held = (line.split() for line in locks.splitlines() if key in line)
    return {int(words[4]) for words in held if words[1] == "FLOCK" and words[5] == key and words[4].isdigit()}


def program_name(pid: int | str = "self") -> str:
    """Return a process's command line, shortened for messages; "?" if the process has ended."""
    try:
        words = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
    except OSError:
        return "?"
    text = [word.decode(errors="replace") for word in words if word]
    if text and Path(text[0]).name.startswith("python") and len(text) > 1:
        text = text[1:]
    if text[:1] == ["-c"]:  # its code says nothing to people
        text = ["python -c", *text[2:]]
    return printable(" ".join([Path(text[0]).name, *text[1:3]]), 80) if text else "?"


def holders_of_address(place: str, *, own: bool = False) -> list[Holder]:
    """Return the processes with an `AddressClaim` on this place, as far as this user may see them."""
    try:
        sockets = Path("/proc/net/unix").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return []
    bound = f"@{_claim_name(place)}"
    nodes = {
        f"socket:[{words[6]}]"
        for line in sockets
        if len(words := line.split(None, 7)) == 8 and words[7] == bound
    }
    found = {pid for pid, _, target in _open_files() if target in nodes} if nodes else set()
    return _called(found - (set() if own else {os.getpid()}))


_ADDRESS_CLAIM = "eehal port "
_LONGEST_NAME = 90
"""Longest place in the name of a socket, which has 107 bytes; of a longer one the hash stands there."""


def _claim_name(place: str) -> str:
    return _ADDRESS_CLAIM + (place if len(place) <= _LONGEST_NAME else sha256(place.encode()).hexdigest())


class AddressClaim:
    """A claim on an address in a network: the name of a Unix socket, which ends with its process.

    Args:
        place: host and port.

    Raises:
        LinkBusyError: another link or program of this machine has the claim.
    """

    def __init__(self, place: str) -> None:
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            self._socket.bind(f"\0{_claim_name(place)}")
        except OSError as error:
            self._socket.close()
            who = " and ".join(map(str, holders_of_address(place, own=True))) or "another program"
            raise LinkBusyError(
                f"the address is used by {who}.",
                where=place,
                todo="Stop that program, or give each device one link: two users of a device disturb each other.",
            ) from error

    def release(self) -> None:
        """Release the claim; a second call has no effect."""
        self._socket.close()


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
