"""One client of the owner, and what it waits for."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from end_effector_hal.errors import LineBusyError
from end_effector_hal.vocabulary import LastWill


class LastWillRunsError(LineBusyError):
    """The will of the one who had these lines is not over yet; ``retry_us`` says when it is."""

    def __init__(self, what: str, retry_us: int) -> None:
        super().__init__(what)
        self.retry_us = retry_us


def process_words(pid: int, program: str) -> str:
    """A process for people: its pid and how it was called; pid 0: it runs where the owner does not see it."""
    named = f", {program}" if program else ""
    return f"pid {pid}{named}" if pid else "in another container"


class Write(NamedTuple):
    """Levels that are applied together, not before ``due``."""

    due: int
    levels: Mapping[str, bool]


@dataclass(eq=False)
class Session:
    """One client that writes lines.

    ``token``: by which it is known again when it comes back; empty: it never is. ``pid``: only for people, 0 where
    the client runs in a PID namespace that the owner does not see, as in another container.
    ``ended``: it has gone, what is queued is still to be done. ``absent``: an owner before this one knew it, and it
    was not heard of since; it has a lease's time to come back. ``declared_dead``: its lease
    expired and it has come back.
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
        """What waits and would activate one of these lines was given up."""
        given_up = set(lines)
        left = (
            Write(due, {name: level for name, level in levels.items() if not (level and name in given_up)})
            for due, levels in self.queue
        )
        self.queue = deque(write for write in left if write.levels)

    @property
    def process(self) -> str:
        """Which process it is, for people."""
        return process_words(self.pid, self.program)
