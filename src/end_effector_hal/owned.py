"""Functions that open files of the product safely.

They follow no symbolic link, and accept no file that another user owns or can write.
"""

from __future__ import annotations

import errno
import os
import stat
from contextlib import suppress
from pathlib import Path

_SAFELY = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0)
_HAS_USERS = hasattr(os, "geteuid")


def open_owned(path: str | Path, flags: int, mode: int = 0o600, *, shared: bool = False) -> int:
    """Open a file as `os.open` does, but no symbolic link, no special file, and no other user's file.

    With ``shared``, other users may own and write the file, as for simulated wires between two users.

    Raises:
        OSError: the file was refused or cannot be opened; the reason is in its text.
    """
    try:
        fd = os.open(path, flags & ~os.O_TRUNC | _SAFELY, mode)
    except OSError as error:
        if os.path.islink(path):
            raise OSError(errno.ELOOP, "it is a link") from error
        raise
    try:
        found = os.fstat(fd)
        if not stat.S_ISREG(found.st_mode):
            raise OSError(errno.EINVAL, "it is no regular file")
        if not shared:
            _check(found, found.st_mode & stat.S_IWOTH)
        if flags & os.O_TRUNC:
            os.ftruncate(fd, 0)
    except BaseException:
        os.close(fd)
        raise
    return fd


def write_owned(path: Path, data: bytes, mode: int = 0o644) -> None:
    """Write a file completely or not at all, through a temporary file beside it.

    An existing file or link at the path is replaced; the link is not followed.
    """
    beside = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        beside.unlink(missing_ok=True)
        with os.fdopen(open_owned(beside, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "wb") as file:
            file.write(data)
        beside.replace(path)
    except OSError:
        with suppress(OSError):
            beside.unlink()
        raise


def owned_folder(path: Path, mode: int = 0o755) -> Path:
    """Return a folder that only this user or root controls, and create it if it is missing.

    The folder must belong to this user or to root, and no other user may write to it or replace it. One exception: a
    group of this user may write to it if its sticky or setgid bit marks it as shared on purpose, as a service's folder
    is.

    Raises:
        OSError: the folder was refused or cannot be created; the reason is in its text.
    """
    path = path.absolute()
    for each in (*reversed(path.parents), path):
        with suppress(FileExistsError):
            if not os.path.lexists(each):
                each.mkdir(mode)
        found = each.lstat()
        if stat.S_ISLNK(found.st_mode) and each != path:
            _check(found)
            found = each.stat()
        if not stat.S_ISDIR(found.st_mode):
            raise OSError(errno.ENOTDIR, "it is a link, or no directory")
        if _HAS_USERS and each != path and found.st_mode & stat.S_IWOTH and not found.st_mode & stat.S_ISVTX:
            raise OSError(errno.EPERM, f"others may write in {each}")
    if found.st_mode & stat.S_IWGRP and found.st_mode & (stat.S_ISVTX | stat.S_ISGID):
        _check(found, found.st_mode & stat.S_IWOTH, group=found.st_gid)
    else:
        _check(found, found.st_mode & (stat.S_IWGRP | stat.S_IWOTH))
    return path


def _check(found: os.stat_result, written_by_others: int = 0, *, group: int = -1) -> None:
    if not _HAS_USERS:
        return
    if found.st_uid not in (0, os.geteuid()) and group not in (os.getegid(), *os.getgroups()):
        raise OSError(errno.EPERM, f"it belongs to the user {found.st_uid}")
    if written_by_others:
        raise OSError(errno.EPERM, "others may write there")
