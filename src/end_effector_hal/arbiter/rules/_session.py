"""The session of one client, and the records of the sessions and of the arbiter for the next arbiter."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from end_effector_hal.arbiter.protocol import is_token
from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import LastWill, LastWillStep, printable, read_last_will


class SessionRecord(NamedTuple):
    """The record of one client's session.

    Attributes:
        client, token, lines: the client's name, token and lines; an empty token identifies no client.
        will: the valid last will.
        ended: the client has gone, and its last will is being executed.
        pid: for messages only; by now the pid may belong to another process.
        faults: names of the faults that the client has latched.
    """

    client: str
    token: str
    lines: tuple[str, ...]
    will: LastWill
    ended: bool
    pid: int = 0
    faults: tuple[str, ...] = ()


class DrivenLine(NamedTuple):
    """The role of a line for an earlier arbiter, and whether the line may be active.

    ``active`` None: not recorded; a reboot has made the line inactive.
    """

    role: str
    active: bool | None


Driven = Mapping[str, DrivenLine]


@dataclass(frozen=True)
class ArbiterState:
    """The state of an arbiter at one moment.

    Attributes:
        faults: sentences by name, latched until a reset.
        clients: clients that write lines, and those whose last will is being executed.
        clean: whether the arbiter ended in order.
        levels: levels of the lines; a line that is missing here is not compared with the level found.
        dead: names and tokens of clients that were declared dead and have not connected since.
        pulsed: levels of the outputs whose level cannot be read from their lines; a missing output counts as active.
        doubt: why the last wills of these clients must not be executed, a clause; empty: they may be executed.
        unread: whether the journal was not read yet, so that its faults are missing here.
        driven: by line, its role and whether it may be active; empty: not recorded.
        since: by line, the time of its activation, µs; only active lines that have a longest time.
        owed: when the deactivations were commanded, µs, by line, that no device has acknowledged yet; in that order.
        part: name of the part that was gripped last; empty: none, or it has no name.
    """

    faults: Mapping[str, str] = field(default_factory=dict)
    clients: tuple[SessionRecord, ...] = ()
    clean: bool = True
    levels: Mapping[str, bool] = field(default_factory=dict)
    dead: tuple[tuple[str, str], ...] = ()
    pulsed: Mapping[str, bool] = field(default_factory=dict)
    doubt: str = ""
    unread: bool = False
    driven: Driven = field(default_factory=dict)
    since: Mapping[str, int] = field(default_factory=dict)
    owed: Mapping[str, int] = field(default_factory=dict)
    part: str = ""

    def as_json(self) -> dict[str, object]:
        """Return the state as JSON for the session record. ``doubt`` is left out: it arises when the record is read."""
        often_empty = {
            "pulsed": dict(self.pulsed), "unread": self.unread, "driven": dict(self.driven),
            "since": dict(self.since), "owed": dict(self.owed), "part": self.part,
        }  # fmt: skip
        return {
            "faults": dict(self.faults),
            "clients": [
                [*each[:3], [step.as_json() for step in each.will], each.ended, each.pid, each.faults]
                for each in self.clients
            ],
            "clean": self.clean,
            "levels": dict(self.levels),
            "dead": self.dead,
        } | {name: value for name, value in often_empty.items() if value}


def read_arbiter_state(given: Any) -> ArbiterState:
    """Return the state from the output of `ArbiterState.as_json`.

    Raises:
        UsageError: the value is no such state, or has another version.
    """
    try:
        clients = tuple(_read_record(*client) for client in given["clients"])
        levels, pulsed = read_levels(given["levels"]), read_levels(given.get("pulsed", {}))
        dead = tuple((str(client), str(token)) for client, token in given["dead"])
        faults, unread = read_faults(given["faults"]), given.get("unread") is True
        since, owed = (
            {str(line): int(at) for line, at in given.get(name, {}).items()} for name in ("since", "owed")
        )
        return ArbiterState(
            faults, clients, bool(given["clean"]), levels, dead, pulsed, unread=unread,
            driven=read_driven(given), since=since, owed=owed,
            part=printable(str(given.get("part", ""))),
        )  # fmt: skip
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise UsageError(f"this is not the state of a line arbiter: {error}.") from error


def read_levels(given: Any) -> dict[str, bool]:
    """Read levels by line from JSON; raises UsageError."""
    if not isinstance(given, dict):
        raise UsageError("levels must be an object of true and false by line.")
    return {printable(str(line)): level is True for line, level in given.items()}


def read_driven(given: Any) -> dict[str, DrivenLine]:
    """Read the roles in a record from JSON; raises the errors that `read_arbiter_state` catches."""
    return {
        printable(str(line)): DrivenLine(
            printable(str(role)), None if active is None else active is not False
        )
        for line, (role, active) in given.get("driven", {}).items()
    }


def read_faults(given: Any) -> dict[str, str]:
    """Read fault sentences by name from JSON.

    Raises:
        UsageError: the value is not an object.
    """
    if not isinstance(given, dict):
        raise UsageError("faults must be an object of sentences by name.")
    return {printable(str(name)): printable(str(why)) for name, why in given.items()}


def _read_record(
    client: object, token: object, lines: Iterable[object], will: object, ended: object, pid: object,
    faults: Iterable[object] = (),
) -> SessionRecord:  # fmt: skip
    return SessionRecord(
        printable(str(client)),
        token if is_token(token) else "",
        tuple(map(str, lines)),
        read_last_will(will),
        bool(ended),
        pid if type(pid) is int else 0,
        tuple(printable(str(name)) for name in faults),
    )


def process_words(pid: int, program: str) -> str:
    """Return pid and command line for a message; pid 0: a process in a PID namespace that the arbiter does not see."""
    named = f", {program}" if program else ""
    return f"pid {pid}{named}" if pid else "in another container"


class Write(NamedTuple):
    """Levels that are applied together, at ``due`` (µs) or later.

    Attributes:
        drop: a person asked for the deactivations.
        values: registers that make an output grip, by line, where the part decides about them.
    """

    due: int
    levels: Mapping[str, bool]
    drop: bool = False
    values: Mapping[str, tuple[int, ...]] = {}


@dataclass(eq=False)
class Session:
    """The session of one client that writes lines.

    Attributes:
        client, lines: the client's name and its lines.
        token: identifies the client when it connects again; an empty token identifies no client.
        will: the valid last will.
        lease_until: when the lease expires, µs.
        pid, program: for messages only; pid 0: the process runs in a PID namespace that the arbiter does not see.
        ended: the client has gone; its queue still has to be executed.
        absent: the session is from an earlier arbiter, and the client has not connected since; it has the time of a
            lease to do so.
        declared_dead: its lease had expired, or its connection was lost, before it connected again.
        queue: writes that are not applied yet, in order.
        faults: names of the faults that the client has latched and not cleared.
        stuck: why the first write in the queue, a deactivation, cannot be applied; it is tried again, and nothing is
            activated before it.
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
    faults: set[str] = field(default_factory=set)
    stuck: str = ""

    def forget_activations(self, lines: Iterable[str]) -> None:
        """Remove from the queue all activations of these lines."""
        given_up, queue = set(lines), self.queue
        self.queue = deque()
        for write in queue:
            left = {name: level for name, level in write.levels.items() if not (level and name in given_up)}
            if left:
                self.queue.append(write._replace(levels=left))

    def queued_level(self, line: str, *, now: bool) -> bool:
        """Return the level that a line has after the queue is applied; ``now``: its present level."""
        for write in self.queue:
            now = write.levels.get(line, now)
        return now

    @property
    def record(self) -> SessionRecord:
        """The record of this session for the next arbiter.

        Deactivations that still wait in the queue become the first steps of its last will, because they were accepted.
        After the client's end the queue also contains the last will; its steps are not repeated.
        """
        will = self.will
        if self.queue:
            waits = {line for write in self.queue for line in write.levels}
            if self.ended:
                waits -= {step.line for step in will}
            off = (line for line in sorted(waits) if not self.queued_level(line, now=True))
            will = (*map(LastWillStep, off), *will)
        lines, faults = tuple(sorted(self.lines)), tuple(sorted(self.faults))
        return SessionRecord(self.client, self.token, lines, will, self.ended, self.pid, faults)

    @property
    def process(self) -> str:
        """The process of the client, in words."""
        return process_words(self.pid, self.program)
