"""A Unix socket for those who may command the lines: the arbiter's, and those of the programs beside it."""

from __future__ import annotations

import errno
import os
import socket
import threading
from contextlib import suppress
from pathlib import Path

from end_effector_hal.errors import UsageError, WireError
from end_effector_hal.owned import owned_folder

LONGEST_PATH = 107
"""Bytes of the path of a Unix socket."""


def listen(path: Path, group: str | None = None, *, whose: str = "the line arbiter") -> socket.socket:
    """Make a socket for this user and one group only (mode 0660).

    It is bound under another name first, so that a client that finds it can connect.

    Args:
        path: where.
        group: whose members may command the lines; default: that of the process.
        whose: for the sentence of an error.

    Raises:
        UsageError: there is no such group.
        WireError: it cannot be made, or not be given to that group.
    """
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
    """The error for a socket that cannot be made."""
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
