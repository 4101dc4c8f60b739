"""The socket of a server, where clients are accepted."""

from __future__ import annotations

import errno
import logging
import os
import socket
import threading
import time
from contextlib import suppress
from pathlib import Path

from end_effector_hal.errors import UsageError, WireError
from end_effector_hal.owned import owned_folder

_log = logging.getLogger("end_effector_hal.wires")
LONGEST_PATH = 107
"""Longest path of a Unix socket, bytes."""
REST_S = 0.01


class Listener:
    """A non-blocking Unix socket for this user and one group only (mode 0660).

    The socket is bound under another name first, so that a client that finds it can connect. A waiting client keeps
    the socket readable; without a free file descriptor to accept it, a loop would spin. So one descriptor is kept in
    reserve: in that case it is closed, and the client is accepted with it and turned away.

    Args:
        path: the socket; one that was left behind is replaced.
        group: the group whose members may connect; default: the group of the process.
        whose: owner of the socket, for error messages.

    Raises:
        UsageError: the group does not exist.
        WireError: the socket cannot be created, or cannot be given to that group.
    """

    def __init__(self, path: Path, group: str | None = None, *, whose: str = "the line arbiter") -> None:
        self._path, self._whose, self._reported, self._spare = path, whose, False, -1
        self._socket = _bound(path, group, whose)
        self._inode = path.stat().st_ino
        self._reserve()

    def fileno(self) -> int:
        """Return the descriptor for select; it is readable when a client waits."""
        return self._socket.fileno()

    def accept(self) -> socket.socket | None:
        """Accept a client and return its socket; None: no client waits, or it was refused."""
        try:
            sock, _ = self._socket.accept()
        except BlockingIOError:
            return None
        except OSError as error:
            if error.errno != errno.ECONNABORTED:
                self._turn_away(error)
            return None
        self._reported = False
        return sock

    def report(self, error: OSError) -> None:
        """Log why a client is turned away; repetitions are not logged."""
        if not self._reported:
            _log.warning("%s: a client is turned away: %s", self._path, error.strerror or error)
        self._reported = True

    def close(self) -> None:
        """Close the socket and remove its file, unless another server has replaced it."""
        self._release()
        self._socket.close()
        with suppress(OSError):
            if self._path.stat().st_ino == self._inode:
                self._path.unlink()

    def _turn_away(self, error: OSError) -> None:
        self.report(error)
        self._release()
        try:
            self._socket.accept()[0].close()
        except BlockingIOError:
            pass
        except OSError:  # another thread was quicker, or this machine lacks more than files
            time.sleep(REST_S)
        self._reserve()

    def _release(self) -> None:
        spare, self._spare = self._spare, -1
        if spare >= 0:
            os.close(spare)

    def _reserve(self) -> None:
        with suppress(OSError):
            self._spare = os.open(os.devnull, os.O_RDONLY | os.O_CLOEXEC)


def _bound(path: Path, group: str | None, whose: str) -> socket.socket:
    number = -1 if group is None else _number(group)
    if len(os.fsencode(path)) > LONGEST_PATH:  # it could be made, but nobody could connect
        raise no_socket(path, OSError(errno.ENAMETOOLONG, os.strerror(errno.ENAMETOOLONG)), whose)
    try:
        owned_folder(path.parent)
    except OSError as error:
        raise no_socket(path.parent, error, whose) from error
    fresh = path.with_name(f".{os.getpid()}-{threading.get_native_id()}")
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        fresh.unlink(missing_ok=True)
        os.fchmod(listener.fileno(), 0o600)  # until it belongs to the group
        listener.bind(str(fresh))
        _give(fresh, number, group, whose)
        fresh.chmod(0o660)
        listener.listen(64)
        listener.setblocking(False)
        fresh.replace(path)
    except WireError:
        listener.close()
        fresh.unlink(missing_ok=True)
        raise
    except OSError as error:
        listener.close()
        with suppress(OSError):
            fresh.unlink(missing_ok=True)
        raise no_socket(path, error, whose) from error
    return listener


def no_socket(path: Path, error: OSError, whose: str = "the line arbiter") -> WireError:
    """Return the error for a socket that cannot be created."""
    return WireError(
        f"the socket of {whose} cannot be made: {error.strerror or error}.",
        where=str(path),
        todo="Give a path of less than 90 letters in a directory that is no link and that only this user can write.",
    )


def _number(group: str) -> int:
    import grp  # what needs no lines needs no POSIX

    try:
        return int(group) if group.isdigit() else grp.getgrnam(group).gr_gid
    except KeyError:
        raise UsageError(
            f"there is no group {group!r} on this machine.", todo="getent group lists them."
        ) from None


def _give(path: Path, number: int, group: str | None, whose: str) -> None:
    try:
        os.chown(path, -1, number)
    except PermissionError as error:
        raise WireError(
            f"the socket of {whose} cannot be given to the group {group}: {error.strerror}.",
            where=str(path.parent),
            todo="Run it as a member of that group.",
        ) from error
