"""Who has a file open or locked; looks only, opens and locks nothing."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from end_effector_hal.wires import program_name

# As in the errors of the wires; the kernel shows other users' open files to root only.
_PTMX = ("/dev/ptmx", "/dev/pts/ptmx")


class Holder(NamedTuple):
    """A process, and how it was called."""

    pid: int
    program: str

    def __str__(self) -> str:
        return f"pid {self.pid} ({self.program})"


def holders_of(path: str | Path) -> list[Holder]:
    """Who else has it open or locked, as far as this user may see; [] for a file that is not there.

    The process at the other end of a pty is none: it is the cable.
    """
    device = os.path.realpath(path)
    found = set(_lockers(device))
    ends: set[int] = set()
    for pid, link, target in _open_files():
        if target == device:
            found.add(pid)
        elif target in _PTMX and device == f"/dev/pts/{_tty_index(link)}":
            ends.add(pid)
    return [Holder(pid, program_name(pid)) for pid in sorted(found - ends - {os.getpid()})]


def _open_files() -> Iterator[tuple[int, str, str]]:
    for link in glob.iglob("/proc/[0-9]*/fd/*"):
        try:
            yield int(link.split("/")[2]), link, os.readlink(link)
        except OSError:
            continue


def _tty_index(link: str) -> str:
    """Of a master of a pty: the number of its slave."""
    try:
        text = Path(link.replace("/fd/", "/fdinfo/")).read_text(encoding="ascii")
    except OSError:
        return ""
    return next((line.split()[1] for line in text.splitlines() if line.startswith("tty-index:")), "")


def _lockers(path: str) -> Iterator[int]:
    """Of flock(2), from the kernel's list: unlike open files it shows those of every user."""
    try:
        status, locks = os.stat(path), Path("/proc/locks").read_text(encoding="ascii")
    except OSError:
        return
    key = f"{os.major(status.st_dev):02x}:{os.minor(status.st_dev):02x}:{status.st_ino}"
    for line in locks.splitlines():
        words = line.split()
        if len(words) >= 6 and words[1] == "FLOCK" and words[5] == key and words[4].isdigit():
            yield int(words[4])
