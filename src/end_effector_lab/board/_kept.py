"""Which built boards are kept: the newest, and those that somebody uses."""

from __future__ import annotations

import fcntl
import os
import shutil
from pathlib import Path

WHOLE = "root.cpio"
"""Is made last: with it a built board is whole."""

_used: dict[Path, int] = {}


def keep(place: Path) -> bool:
    """Whether a whole board stands there; if so nobody removes it until this process ends."""
    try:
        used = os.open(place, os.O_RDONLY | os.O_DIRECTORY)
    except OSError:
        return False
    fcntl.flock(used, fcntl.LOCK_SH)
    if not (place / WHOLE).exists():  # removed while we waited, or not whole
        os.close(used)
        return False
    before = _used.pop(place, None)
    if before is not None:
        os.close(before)
    _used[place] = used
    return True


def forget_others(place: Path) -> list[str]:
    """Remove every board beside this one that nobody uses, and what builds left that were cut off; returns the names.

    Call it only while nobody else builds.
    """
    others = sorted(each for each in place.parent.iterdir() if each.is_dir() and each != place)
    return [each.name for each in others if _forget(each)]


def _forget(old: Path) -> bool:
    try:
        folder = os.open(old, os.O_RDONLY | os.O_DIRECTORY)
    except OSError:  # of somebody else
        return False
    try:
        fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
        (old / WHOLE).unlink(missing_ok=True)  # first: half of it must not look whole
        shutil.rmtree(old)
    except OSError:  # in use
        return False
    finally:
        os.close(folder)
    return True
