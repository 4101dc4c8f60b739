"""The socket of a program: it sends the program's records to its clients and receives commands (`wires.rpc`).

A process that may command the lines of a program may also read its records and send it commands.

Rule 1: The program never waits. `RecordStream.put` queues records; if the thread of the stream does not keep up, all
clients lose their place and get a new state.

Rule 2: A client first gets a state of the controller, which the program supplies between two jobs, and then every
record after it.

Rule 3: The automata decide on a command; the stream decides nothing.

Rule 4: A failure of the socket never ends a program: it only causes a warning in the log.

The records use the names of the recording (docs/reference/recordings.md). The first is the ``header``; then comes
``state``, the current state of the program (absent if it has not started yet), and after it every record. Four kinds
are in no recording: ``published`` (the status with the additions of the program), ``readings`` (what the sensors read,
after each frame and whenever a reading turns stale), ``health`` (of the links, once a second) and ``alive`` (sent after
0.4 s without another record, while the program works). After a loss of records, ``header`` and a new ``state`` are sent
again.

A request has a ``command`` and, where it concerns one actuator, one plain output or one part, its ``name``. Only the
automata accept or refuse a command; in maintenance the answer comes when the line is written, before a sensor shows
anything.
"""

from __future__ import annotations

import logging
import queue
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from pydantic import Field

from end_effector_hal.arbiter import HAL
from end_effector_hal.control import Answer
from end_effector_hal.description import Description, socket_path
from end_effector_hal.errors import ReportedError
from end_effector_hal.wires import now_us
from end_effector_hal.wires.rpc import Reply, RpcRequest, Server, ask, record_line
from end_effector_hal.wires.sensors import SensorHealth

_log = logging.getLogger("end_effector_hal.runtime")
MOST_WAITING = 2_000
"""Maximum number of records that wait for the thread of the stream."""
LOOK_S = 0.1
"""Interval at which the queue is checked while a client reads, s; the same as for the live page, because each check
costs time.
"""
ALIVE_US, HEALTH_US = 400_000, 1_000_000
AT_ONCE = 65_536
"""Maximum number of bytes sent at once; with more, a fast client would count as slow."""
TOO_LATE = "The command came too late and was not executed."
MAINTENANCE_WORDS = ("activate", "deactivate")
"""Commands for one actuator (IL-12)."""
RELOAD, GO_ON = "reload", "go-on"
RELOAD_WORDS = (RELOAD, GO_ON)
"""``reload`` checks whether the program can adopt the current description file; if it can, nothing is activated for
30 s, or until ``go-on``.
"""
SWITCH_WORDS = ("switch-on", "switch-off")
"""Commands for one plain output."""
PUBLISHED, READINGS, HEALTH = "published", "readings", "health"
"""Kinds of the records that are in no recording: a published status, what the sensors read, the state of the links."""
URGENT = (PUBLISHED, READINGS)
"""Kinds that are sent at once: a client waits for the statuses after its command, and publishes readings itself."""
OF_CHANGER = ("lock", "unlock", "arm", "reset")
"""Commands for the tool changer."""
WORDS = ("grip", "drop", "cancel", "resume", "acknowledge", *MAINTENANCE_WORDS, *OF_CHANGER)
"""Commands of a tool; ``acknowledge``: a person has seen the alarms that are over."""


@dataclass(frozen=True, slots=True)
class ProgramCommand(RpcRequest):
    """One command of a client."""

    command: Annotated[str, Field(max_length=40)]
    name: Annotated[str, Field(max_length=100)] = ""
    """Of the actuator, the output, or the part that is to be gripped."""


def program_socket(description: Description) -> Path:
    """Return the path of the program's socket, next to that of the line arbiter; raises WireError as
    `socket_path` does.
    """
    arbiter = socket_path(description)
    return arbiter.with_name(f"{arbiter.name}.{HAL}")


def ask_program(path: Path, command: str) -> Answer:
    """Send a command to a program and wait for the answer; if none comes, return an undecided answer."""
    return Answer(*ask(path, "The HAL", command=command))


Entry = tuple[str, int, object]
"""A record: kind, time (µs) and content."""
Commander = Callable[[ProgramCommand], Answer]


class RecordStream:
    """Serves the records of a program on a socket, from `serve` to `close`.

    `put` and `begin` never wait; only one thread at a time may call them.

    Args:
        path: the Unix socket: mode 0660, with the group of ``beside``.
        beside: the socket of the line arbiter, whose group is copied.
        header: makes the first record for a client.
        words: the commands that the program accepts.
    """

    def __init__(
        self, path: Path, beside: Path, header: Callable[[int], object], words: Collection[str]
    ) -> None:
        self._path, self._beside, self._header, self._words = path, beside, header, frozenset(words)
        self.wants_state = False
        """Whether a client waits for a state; if so, call `begin`."""
        self._active = False
        self._batches: queue.SimpleQueue[tuple[bool, Sequence[Entry]]] = queue.SimpleQueue()
        self._put_count = self._sent_count = 0  # each counted by one side only
        self._alive_at = self._health_at = 0
        self._server: Server | None = None

    @property
    def is_read(self) -> bool:
        """Whether a client receives records, or waits for its first."""
        return self._active or self.wants_state

    def serve(
        self,
        command: Commander,
        alive: Callable[[], bool],
        nudge: Callable[[], None],
        health: Callable[[], SensorHealth],
    ) -> None:
        """Create the socket and start to serve; raise nothing.

        Args:
            command: passes a command to the program, in a thread that may wait.
            alive: returns whether the program works.
            nudge: makes the program run a job without an event, so that it checks :attr:`wants_state`; must not wait.
            health: returns the state of the sensor links and inputs.
        """
        self._command, self._alive, self._nudge, self._health = command, alive, nudge, health
        try:
            group = str(self._beside.stat().st_gid)
            server = Server(
                self._path,
                group=group,
                whose="a program",
                greets=True,
                request=ProgramCommand,
                handle=self._decide,
            )
            server.start("stream", lambda: self._turn(server))
        except (ReportedError, OSError, RuntimeError) as error:
            _log.warning("the live page cannot show this program: %s", error)
        else:
            self._server = server

    def put(self, batch: Sequence[Entry]) -> None:
        """Queue records for all clients; return at once."""
        if not self._active or not batch:
            return
        if self._put_count - self._sent_count + len(batch) > MOST_WAITING:
            self._active = False  # until everybody got a new state
            self._batches.put((False, ()))
            return
        self._put_count += len(batch)
        self._batches.put((False, batch))
        if self._server is not None and any(kind in URGENT for kind, _, _ in batch):
            self._server.wake()

    def begin(self, first: Sequence[Entry]) -> None:
        """Send the header and these records to the waiting clients; return at once."""
        self.wants_state, self._active = False, True
        self._batches.put((True, first))
        if self._server is not None:
            self._server.wake()

    def close(self) -> None:
        """Close all connections and remove the socket."""
        if self._server is not None:
            self._server.close()

    # From here on: in the threads of the server.

    def _turn(self, server: Server) -> float | None:
        sent, at = self._send_all(server), now_us()
        if sent:
            self._alive_at = at
        elif at - self._alive_at >= ALIVE_US and len(server) and self._alive():
            self._alive_at = at
            server.send(record_line("alive", at, {}))
        if at - self._health_at >= HEALTH_US and len(server) and self._alive():
            self._health_at = at
            server.send(record_line(HEALTH, at, self._health()))
        if not len(server):
            self._active = False
        if server.has_newcomers and not self.wants_state:
            self.wants_state = True
            self._nudge()
        return LOOK_S if len(server) else None

    def _send_all(self, server: Server) -> bool:
        sent, following = False, bytearray()  # of several batches: one call of the system for each reader
        while not self._batches.empty():
            begins, batch = self._batches.get()
            self._sent_count += 0 if begins else len(batch)
            sent = True
            lost = not batch and not begins
            if following and (begins or lost or len(following) > AT_ONCE):
                server.send(bytes(following))
                following.clear()
            if lost:
                server.lose_all()
                continue
            data = b"".join(record_line(*entry) for entry in batch)
            if begins:
                at, self._health_at = now_us(), 0
                server.begin(record_line("header", at, self._header(at)) + data)
            else:
                following += data
        if following:
            server.send(bytes(following))
        return sent

    def _decide(self, message: ProgramCommand) -> Reply:
        if message.command not in self._words:
            return Reply(False, f"There is no such command here; there are {', '.join(sorted(self._words))}.")
        answer = self._command(message)
        return Reply(answer.accepted, answer.reason, answer.decided, answer.count)
