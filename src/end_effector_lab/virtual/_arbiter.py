"""The line arbiter in virtual time: its rules, session record, journal, disk and lines, without a socket."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from end_effector_hal.arbiter import LineArbiter, Policy
from end_effector_hal.arbiter.records import NO_ANSWER, Journal, JournalEntry, Records, SessionStore
from end_effector_hal.arbiter.rules import Driven
from end_effector_hal.description import Description
from end_effector_hal.wires.lines import LineBackend


class Edge(NamedTuple):
    """A line changed at ``at`` µs."""

    at: int
    line: str
    level: bool


class Switching(NamedTuple):
    """The output of an actuator became active or inactive at ``at`` µs."""

    at: int
    name: str
    active: bool

    def __str__(self) -> str:
        return f"{self.name} {'on' if self.active else 'off'}"


def switchings(description: Description, edges: Iterable[Edge]) -> Iterator[Switching]:
    """Yield the switchings of actuators with one line, two coils or pulses; the last coil decides."""
    by_line = {actuator.line: name for name, actuator in description.ordered}
    second = {each.line: by_line[line] for line, each in description.opposites.items() if line in by_line}
    for edge in edges:
        if edge.line in second:
            if edge.level:
                yield Switching(edge.at, second[edge.line], False)
        elif (name := by_line.get(edge.line)) and (edge.level or edge.line not in description.opposites):
            yield Switching(edge.at, name, edge.level)


class VirtualOutputs:
    """A `LineBackend` whose lines exist only in virtual time.

    Args:
        names: names of all lines of the board.
        active: lines that are active at the start.
        clock: returns the time, µs.
        on_edge: called with each change.
    """

    def __init__(
        self,
        names: Sequence[str],
        active: Mapping[str, bool],
        clock: Callable[[], int],
        on_edge: Callable[[Edge], None],
    ) -> None:
        self._levels = {name: active.get(name, False) for name in names}
        self._clock, self._on_edge = clock, on_edge

    def request(self, names: Sequence[str]) -> dict[str, bool]:
        """Return the levels of the requested lines, which stay unchanged; see `LineBackend`."""
        return {name: self._levels[name] for name in names}

    def levels(self) -> dict[str, bool]:
        """Return the levels of all lines."""
        return dict(self._levels)

    def set(self, levels: Mapping[str, bool]) -> None:
        """Set the levels of some lines at once."""
        for name, level in levels.items():
            if self._levels[name] != level:
                self._levels[name] = level
                self._on_edge(Edge(self._clock(), name, level))

    def close(self) -> None:
        """Leave the lines as they are."""


class VirtualDisk:
    """A `Storage`: the bytes of one file.

    Attributes:
        content: the bytes that a process reads.
        safe: the bytes that survive a loss of power.
        full: no room for a new file.
        fails: every access raises an I/O error.
        hangs: a read at the start and every write never end.
    """

    def __init__(self) -> None:
        self.content = bytearray()
        self.safe = b""
        self.full = self.fails = self.hangs = False

    def read(self) -> bytes:
        """Return the whole content."""
        self._check(0)
        return bytes(self.content)

    def create(self, content: bytes, size: int) -> None:
        """Create a new file in one step; it survives a loss of power."""
        self._check(size)
        self.content = bytearray(content.ljust(size, b"\0"))
        self.sync()

    def write(self, at: int, data: bytes) -> None:
        """Overwrite bytes in place."""
        self._check(0)
        if not self.content:
            raise OSError(errno.ENOENT, os.strerror(errno.ENOENT))
        self.content[at : at + len(data)] = data

    def sync(self) -> None:
        """Make the content safe against a loss of power."""
        self._check(0)
        self.safe = bytes(self.content)

    def remove(self) -> None:
        """Delete the file; this works on a full disk as well."""
        self.content = bytearray()

    def close(self) -> None:
        """Do nothing, since nothing is open."""

    def lose_power(self) -> None:
        """Discard the content that was not synced."""
        self.content = bytearray(self.safe)

    def _check(self, room: int) -> None:
        if self.fails:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        if room and self.full:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


RETRY_US = 1_000_000


@dataclass
class Memories:
    """The stores that outlive the process of the arbiter.

    Attributes:
        sessions, mark: the session record and its number, in memory that a loss of power clears.
        journal: the latched faults, on a disk.
        boot: name of this start of the machine.
    """

    sessions: VirtualDisk = field(default_factory=VirtualDisk)
    mark: VirtualDisk = field(default_factory=VirtualDisk)
    journal: VirtualDisk = field(default_factory=VirtualDisk)
    boot: str = "boot 0"

    def lose_power(self, boot: str) -> None:
        """Keep only the synced content of the disk; ``boot`` names the next start."""
        self.journal.lose_power()
        self.sessions.remove()
        self.mark.remove()
        self.boot = boot


class VirtualJournal:
    """Replaces a `JournalThread`; a working disk takes no time."""

    def __init__(self, disk: VirtualDisk, boot: str, clock: Callable[[], int]) -> None:
        self._disk, self._clock = disk, clock
        self._journal = Journal(disk, boot, clock)
        self._is_read = False
        self.due: int | None = None
        """Time of the next attempt to write, µs; None: everything is written."""

    @property
    def trouble(self) -> str:
        """See `JournalThread`."""
        return self._journal.trouble

    def read(self) -> JournalEntry:
        """See `JournalThread`."""
        return self.late() or NO_ANSWER

    def late(self) -> JournalEntry | None:
        """See `JournalThread`."""
        if self._is_read or self._disk.hangs:
            return None
        self._is_read = True
        return self._journal.begin(self._journal.read())

    def keep(self, faults: Mapping[str, str], pulsed: Mapping[str, bool], driven: Driven) -> None:
        """See `JournalThread`."""
        self._journal.keep(faults, pulsed, driven)
        if self._journal.changed.is_set():
            self._journal.changed.clear()
            self._write()

    def step(self) -> None:
        """Write the data that could not be written before."""
        if self.due is not None and self.due <= self._clock():
            self._write()

    def close(self, faults: Mapping[str, str], pulsed: Mapping[str, bool], driven: Driven) -> None:
        """See `JournalThread`."""
        if late := self.late():
            faults = {**late.faults, **faults}
        self._journal.keep(faults, pulsed, driven, clean=True)
        self._write()

    def _write(self) -> None:
        written = self._is_read and not self._disk.hangs and self._journal.write_next()
        self.due = None if written else self._clock() + RETRY_US


class VirtualArbiter:
    """One life of the arbiter.

    Args:
        lines: the outputs.
        policy: the policy of the tool.
        memories: the stores of the earlier lives.
        clock: returns the time, µs.
    """

    def __init__(
        self, lines: LineBackend, policy: Policy, memories: Memories, clock: Callable[[], int]
    ) -> None:
        self._clock = clock
        self._journal = VirtualJournal(memories.journal, memories.boot, clock)
        sessions = SessionStore(memories.sessions, memories.mark, memories.boot, clock)
        self._records = Records(sessions, self._journal)
        self.rules = LineArbiter(lines, policy, clock(), self._records.before, self._records.before_change)
        self._asked_at: int | None = None
        self.keep()

    @property
    def due(self) -> int | None:
        """Time at which `step` must be called, µs."""
        waits_until = None if self._asked_at is None else self._asked_at + self.rules.policy.lease_us
        if waits_until is not None and waits_until <= self._clock():
            waits_until = None
        found = [at for at in (self.rules.deadline, self._journal.due, waits_until) if at is not None]
        return min(found, default=None)

    @property
    def ends(self) -> bool:
        """Whether the arbiter was asked to end."""
        return self._asked_at is not None

    @property
    def is_over(self) -> bool:
        """Whether the arbiter was asked to end and has nothing left to wait for."""
        return self._asked_at is not None and self.rules.may_end(self._asked_at, self._clock())

    def end(self) -> None:
        """Ask the arbiter to end properly."""
        self._asked_at = self._clock()

    def step(self) -> None:
        """Process all that is due: leases, waiting writes, last wills, the journal."""
        at = self._clock()
        self.rules.expire(at)
        self.rules.advance(at)
        self._journal.step()
        self.keep()

    def keep(self) -> None:
        """Store the records before a client learns of a change."""
        self._records.keep(self.rules)

    def reset(self) -> dict[str, str]:
        """Reset as `LineArbiter.reset` does."""
        try:
            return self.rules.reset(self._clock(), self._records.troubles())
        finally:
            self.keep()

    def told(self, predicates: Mapping[str, bool], at_us: int) -> None:
        """Process predicates from the process that reads the sensors; raises UsageError."""
        latched = len(self.rules.predicates.faults)
        self.rules.predicates.update(predicates, at_us, self._clock())
        if len(self.rules.predicates.faults) != latched:
            self.keep()

    def read(self, predicates: Mapping[str, bool], at_us: int) -> None:
        """Process predicates from the arbiter's own inputs."""
        self.rules.predicates.read(predicates, at_us)
        self.keep()

    def close(self) -> None:
        """End now; the lines keep their levels."""
        self.rules.end_pulses()
        self._records.close(self.rules.state, self.rules.policy)
