"""The process of the line arbiter in virtual time: its rules, answers and records, and the thread of its journal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from end_effector_hal.arbiter.protocol import write_message
from end_effector_hal.arbiter.records._journal import Journal, JournalEntry
from end_effector_hal.arbiter.records._records import Records
from end_effector_hal.arbiter.records._session_store import SessionStore
from end_effector_hal.arbiter.rules._arbiter import LineArbiter
from end_effector_hal.arbiter.rules._policy import Policy
from end_effector_hal.arbiter.server._connections import Connection
from end_effector_hal.arbiter.server._requests import RequestHandler
from tests.unit.arbiter.simulation.wire import FarEnd


class Lines:
    """The output lines; they keep their level whoever dies."""

    def __init__(self, world: Any) -> None:
        self._world = world

    def request(self, names: list[str]) -> dict[str, bool]:
        return {name: self._world.lines[name] for name in names}

    def levels(self) -> dict[str, bool]:
        return dict(self._world.lines)

    def set(self, levels: Mapping[str, bool]) -> None:
        self._world.hazard("before a line")
        for name, level in levels.items():
            self._world.judge.line(name, level)
            self._world.lines[name] = level
        self._world.hazard("after a line")

    def close(self) -> None:
        """They stay as they are."""


class JournalThread:
    """Writes a little later than it is asked to, and again every second until it could."""

    def __init__(self, world: Any) -> None:
        self._world, self._journal = world, Journal(world.disk, world.boot, world.clock)
        self._next: int | None = None

    @property
    def trouble(self) -> str:
        return self._journal.trouble

    def read(self) -> JournalEntry:
        return self._journal.read()

    def late(self) -> None:
        return None

    def keep(self, faults: dict[str, str], pulsed: dict[str, bool], driven: Any) -> None:
        self._journal.keep(faults, pulsed, driven)
        if self._journal.changed.is_set():
            self._journal.changed.clear()
            self._next = self._world.now + self._world.random.choice((0, 1_000, 20_000))

    def step(self) -> None:
        """Time has passed."""
        if self._next is not None and self._next <= self._world.now and not self._world.disk.hangs:
            self._next = None if self._journal.write_next() else self._world.now + 1_000_000

    def close(self, faults: dict[str, str], pulsed: dict[str, bool], driven: Any) -> None:
        self._journal.keep(faults, pulsed, driven, clean=True)
        if not self._world.disk.hangs:
            self._journal.write_next()


class ArbiterProcess:
    """As `ArbiterServer`, without a selector."""

    def __init__(self, world: Any, policy: Policy) -> None:
        self._world = world
        self._connections: dict[FarEnd, Connection] = {}
        self.journal = JournalThread(world)
        self._records = Records(SessionStore(world.memory, world.mark, world.boot, world.clock), self.journal)
        self.rules = LineArbiter(
            Lines(world), policy, world.now, self._records.before, self._records.before_change
        )
        self._records.keep(self.rules)
        self._requests = RequestHandler(self.rules, self._records, self._drop)

    def accept(self, far: FarEnd) -> None:
        self._connections[far] = Connection(far, self._world.now)  # type: ignore[arg-type]

    def hear(self, far: FarEnd) -> None:
        """Somebody has sent something; in the world the arbiter may die at any of its points."""
        with self._world.inside("arbiter"):
            connection = self._connections.get(far)
            if connection is None:
                return
            connection.receive()
            while (line := connection.next_line()) is not None:
                self._world.message(line)
                reply = self._requests.handle(connection, line)
                self._world.hazard("before a reply")
                if connection.closed:
                    return
                if reply is not None:
                    connection.put(write_message(reply))
                self._world.hazard("after a reply")
            if connection.ended:
                self._drop(connection, "its socket was closed")

    def step(self) -> None:
        """Time has passed."""
        with self._world.inside("arbiter"):
            over = self.rules.expire(self._world.now)
            for connection in [each for each in self._connections.values() if each.session in over]:
                self._drop(connection, "its lease expired")
            self.rules.advance(self._world.now)
            self._records.keep(self.rules)
            self.journal.step()

    def close(self) -> None:
        """SIGTERM: it ends in order."""
        with self._world.inside("arbiter"):
            self._records.close(self.rules.state, self.rules.policy)

    def _drop(self, connection: Connection, why: str) -> None:
        if connection.closed:
            return
        connection.close()
        self._connections = {far: each for far, each in self._connections.items() if each is not connection}
        self._requests.left(connection)
        session, connection.session = connection.session, None
        if session and not session.ended:
            self.rules.declare_dead(session, why, self._world.now)
