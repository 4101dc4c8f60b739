"""A directory in a place where everybody may write."""

from __future__ import annotations

import os
import stat
from contextlib import suppress
from pathlib import Path

from end_effector_hal.errors import WireError


def own_directory(path: Path) -> Path:
    """The directory, made if it is missing, for this user alone (mode 0700).

    Somebody else may have been there first, with a directory or a link of that name: then it is refused.

    Raises:
        WireError: it is not a directory, or belongs to another user, or others may write there.
    """
    try:
        with suppress(FileExistsError):
            path.mkdir(mode=0o700)
        fd = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
    except OSError as error:
        why = "it is a link, or no directory" if path.is_symlink() or path.exists() else error.strerror
        raise _refusal(path, f"{why}") from error
    try:
        found = os.fstat(fd)
        if found.st_uid != os.geteuid():
            raise _refusal(path, f"it belongs to the user {found.st_uid}")
        if found.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
            raise _refusal(path, "others may write there")
        os.fchmod(fd, 0o700)
    finally:
        os.close(fd)
    return path


def _refusal(path: Path, why: str) -> WireError:
    return WireError(
        f"the run directory is not for this user alone: {why}.",
        where=str(path),
        todo="Set EEHAL_RUN_DIR to a directory that only the programs of the tool can write, or remove that one.",
    )
