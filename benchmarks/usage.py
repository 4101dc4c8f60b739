"""Measures processor time, memory and wake-ups of processes. Source: proc(5)."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

TICKS = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True)
class Usage:
    """The use of resources over a time span.

    Attributes:
        cpu_percent: share of one core, all threads, user and system.
        pss_kib: memory at its end, shared pages counted in proportion.
        rss_kib: memory at its end, shared pages counted in full.
        wakeups_per_s: voluntary context switches of all threads.
        seconds: the span.
    """

    cpu_percent: float
    pss_kib: int
    rss_kib: int
    wakeups_per_s: float
    seconds: float

    def joined(self, other: Usage | None) -> Usage:
        """Return both spans as one; memory is the larger value."""
        if other is None:
            return self
        seconds = self.seconds + other.seconds

        def mean(name: str) -> float:
            return float(getattr(self, name) * self.seconds + getattr(other, name) * other.seconds) / seconds

        return Usage(
            mean("cpu_percent"),
            max(self.pss_kib, other.pss_kib),
            max(self.rss_kib, other.rss_kib),
            mean("wakeups_per_s"),
            seconds,
        )


class Meter:
    """Measures some processes from its creation on.

    Args:
        pids: process ids by name.
    """

    def __init__(self, pids: Mapping[str, int]) -> None:
        self._pids = dict(pids)
        self._begun = time.monotonic()
        self._ticks = {name: _ticks(pid) for name, pid in pids.items()}
        self._switches = {name: _switches(pid) for name, pid in pids.items()}

    def read(self) -> dict[str, Usage]:
        """Return the usage from the beginning until now."""
        seconds = time.monotonic() - self._begun
        return {name: self._usage(name, pid, seconds) for name, pid in self._pids.items()}

    def _usage(self, name: str, pid: int, seconds: float) -> Usage:
        ticks = _ticks(pid) - self._ticks[name]
        memory = _memory(pid)
        return Usage(
            cpu_percent=100 * ticks / TICKS / seconds,
            pss_kib=memory["Pss"],
            rss_kib=memory["Rss"],
            wakeups_per_s=(_switches(pid) - self._switches[name]) / seconds,
            seconds=seconds,
        )


def _ticks(pid: int) -> int:
    # after the name, which may hold spaces: fields 14 and 15 of the whole line
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return int(fields[11]) + int(fields[12])


def _memory(pid: int) -> dict[str, int]:
    lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()[1:]
    return {line.split(":")[0]: int(line.split()[1]) for line in lines}


def _switches(pid: int) -> int:
    total = 0
    for status in Path(f"/proc/{pid}/task").glob("*/status"):
        with suppress(OSError):  # a thread that has just ended
            lines = status.read_text().splitlines()
            total += sum(int(line.split()[1]) for line in lines if line.startswith("voluntary"))
    return total
