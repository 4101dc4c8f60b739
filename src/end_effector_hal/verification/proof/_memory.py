"""Limit the memory of a proof: a machine without free memory kills programs, perhaps those of a tool."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from timed_automata.errors import StoppedError

GIB = 2**30
TIMES_LEFT = 3
"""A proof is stopped when its memory exceeds this multiple of the free memory; it alone may take three quarters of
all.
"""
_TODO = "Give it more memory, or a smaller network: fewer actuators, or without --free-sensors."


class MemoryBound:
    """Stops an exploration that takes too much memory; there is no limit if the system does not report its memory.

    Args:
        most_bytes: maximum for this process; None: 75 % of the memory that the machine, and each control group of the
            process (a container, a slice of systemd), has for it.
        root: the root of the file system.
    """

    def __init__(self, most_bytes: int | None = None, root: Path = Path("/")) -> None:
        self._most, self._proc = most_bytes, root / "proc"
        self._groups = tuple(_groups(root)) if most_bytes is None else ()

    def check(self, states: int) -> None:
        """Raise StoppedError when the process has taken too much memory; ``states``: number of states found so far."""
        try:
            taken = _value(self._proc / "self" / "status", "VmRSS:")
            if self._most is not None:
                most, because = self._most, f"--memory allows {self._most / GIB:.2f} GiB"
            else:
                left = self._left()
                most, because = (
                    TIMES_LEFT * left,
                    f"that is 75 % of the memory, {left / GIB:.2f} GiB are left",
                )
        except (OSError, ValueError):
            return
        if taken > most:
            what = f"stopped after {states:,} states, {taken / GIB:.2f} GiB: {because}."
            raise StoppedError(what, todo=_TODO)

    def _left(self) -> int:
        left = _value(self._proc / "meminfo", "MemAvailable:")
        for group in self._groups:
            with suppress(OSError, ValueError):  # it has no limit
                left = min(left, group.left())
        return max(left, 0)


class _ControlGroup(NamedTuple):
    limit: Path
    usage: Path
    stat: Path
    cache: str  # what of the usage the kernel gives up when it is needed

    def left(self) -> int:
        """Return the free memory, bytes; raises OSError or ValueError if the group has no limit."""
        limit = int(self.limit.read_text())
        return limit - int(self.usage.read_text()) + _value(self.stat, self.cache)


def _groups(root: Path) -> Iterator[_ControlGroup]:
    """Yield the control groups of this process, of either version, with their parents."""
    mounted = root / "sys" / "fs" / "cgroup"
    try:
        lines = (root / "proc" / "self" / "cgroup").read_text().splitlines()
    except OSError:
        return
    for line in lines:
        _, controllers, name = line.split(":", 2)
        if controllers not in ("", "memory"):
            continue
        folder = mounted / controllers
        names = ("limit_in_bytes", "usage_in_bytes") if controllers else ("max", "current")
        cache = "total_inactive_file" if controllers else "inactive_file"
        path = PurePosixPath(name.strip("/"))
        for at in (path, *path.parents):
            limit, usage = (folder / at / f"memory.{each}" for each in names)
            yield _ControlGroup(limit, usage, folder / at / "memory.stat", cache)


def _value(file: Path, key: str) -> int:
    """Return the bytes after a key, such as ``VmRSS:    1024 kB``; raises OSError or ValueError if it is missing."""
    for line in file.read_text().splitlines():
        name, *rest = line.split()
        if name == key:
            return int(rest[0]) * (1024 if rest[1:] == ["kB"] else 1)
    raise ValueError(key)
