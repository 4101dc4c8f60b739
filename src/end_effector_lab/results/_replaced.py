"""A folder that is written beside an older one and then takes its place."""

from __future__ import annotations

import os
import shutil
import stat
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from end_effector_hal.cli import the_folder
from end_effector_hal.errors import UsageError, os_errors


@contextmanager
def replaced_folder(
    folder: Path, names: Collection[str], is_ours: Callable[[Path], bool], noun: str
) -> Iterator[Path]:
    """An empty folder to write in, which takes the place of ``folder`` on leaving; an error leaves the old one.

    Args:
        folder: is made, or replaced.
        names: files that the old one may hold: nothing else is ever removed.
        is_ours: whether the old one, which is not empty, was written by this program.
        noun: who writes it, for the error.

    Raises:
        UsageError: the old one is no folder, or holds something else; or the new one cannot be made.
    """
    _check(folder, names, is_ours, noun)
    new, old = (folder.with_name(f".{folder.name}.{end}.{os.getpid()}") for end in ("new", "old"))
    the_folder(folder.parent)
    with os_errors("The folder cannot be made", new):
        new.mkdir()
    try:
        yield new
        there = _check(folder, names, is_ours, noun)
        with os_errors("The folder cannot be replaced", folder):
            if there:
                folder.rename(old)
            new.rename(folder)
    finally:
        shutil.rmtree(new, ignore_errors=True)  # made here, and gone by now if all went well
        with suppress(OSError):
            for name in names:
                (old / name).unlink(missing_ok=True)
            old.rmdir()


def _check(folder: Path, names: Collection[str], is_ours: Callable[[Path], bool], noun: str) -> bool:
    """Whether there is a folder to be replaced."""
    todo = "Move it away, or name another folder with -o."
    try:
        if not stat.S_ISDIR(os.lstat(folder).st_mode):
            raise UsageError("This is not a folder.", where=str(folder), todo=todo)
        found = sorted(os.scandir(folder), key=lambda each: each.name)
    except FileNotFoundError:
        return False
    except OSError as error:
        raise UsageError(f"The folder cannot be read: {error.strerror}.", where=str(folder)) from None
    other = [each.name for each in found if each.name not in names or not each.is_file(follow_symlinks=False)]
    if other:
        raise UsageError(f"It holds {other[0]!r}, which no {noun} wrote.", where=str(folder), todo=todo)
    if found and not is_ours(folder):
        raise UsageError(f"It holds what no {noun} wrote.", where=str(folder), todo=todo)
    return True
