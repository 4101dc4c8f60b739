"""One client of the arbiter, what waits for its lines, and what the next arbiter must know of it."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from end_effector_hal.arbiter.rules._state import SessionRecord
from end_effector_hal.vocabulary import LastWill, LastWillStep


def process_words(pid: int, program: str) -> str:
    """A process for people: its pid and its command line; pid 0: it runs where the arbiter does not see it."""
    named = f", {program}" if program else ""
    return f"pid {pid}{named}" if pid else "in another container"


class Write(NamedTuple):
    """Levels that are applied together, not before ``due`` (µs)."""

    due: int
    levels: Mapping[str, bool]


@dataclass(eq=False)
class Session:
    """One client that writes lines.

    Attributes:
        client, lines: its name, and what it writes.
        token: identifies the client when it connects again; an empty token identifies nobody.
        will: the last will that is valid now.
        lease_until: when the lease expires, µs.
        pid, program: for people only; pid 0: it runs in a PID namespace that the arbiter does not see.
        ended: the client has gone; its queue is still to be executed.
        absent: an earlier arbiter knew it, and it has not connected since; it has the time of a lease to do so.
        declared_dead: its lease had expired, or its connection was lost, before it connected again.
        queue: writes that are not applied yet, in order.
    """

    client: str
    token: str
    lines: frozenset[str]
    will: LastWill
    lease_until: int
    pid: int = 0
    program: str = ""
    ended: bool = False
    absent: bool = False
    declared_dead: bool = False
    queue: deque[Write] = field(default_factory=deque)

    def forget_activations(self, lines: Iterable[str]) -> None:
        """Remove from the queue what would activate one of these lines."""
        given_up = set(lines)
        left = (
            Write(due, {name: level for name, level in levels.items() if not (level and name in given_up)})
            for due, levels in self.queue
        )
        self.queue = deque(write for write in left if write.levels)

    def queued_level(self, line: str) -> bool | None:
        """The level of a line once the queue is applied; None: no write of this line waits."""
        waiting = [write.levels[line] for write in self.queue if line in write.levels]
        return waiting[-1] if waiting else None

    @property
    def record(self) -> SessionRecord:
        """What the next arbiter must know of it.

        Deactivations that still wait in the queue come first in its last will: they were accepted.
        """
        will = self.will
        if not self.ended:
            waits = {line for write in self.queue for line in write.levels}
            off = (line for line in sorted(waits) if not self.queued_level(line))
            will = tuple(map(LastWillStep, off)) + will
        lines = tuple(sorted(self.lines))
        return SessionRecord(self.client, self.token, lines, will, self.ended, self.pid)

    @property
    def process(self) -> str:
        """The process, for people."""
        return process_words(self.pid, self.program)
