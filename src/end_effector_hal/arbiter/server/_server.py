"""The process of the line arbiter: one thread, one socket, one timer."""

from __future__ import annotations

import logging
import os
import selectors
import signal
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Protocol

from end_effector_hal._closing import Closing
from end_effector_hal.arbiter.protocol import write_message
from end_effector_hal.arbiter.records import Journal, Records, SessionStore
from end_effector_hal.arbiter.records._journal import JournalThread
from end_effector_hal.arbiter.records._records import recorded_left_behind
from end_effector_hal.arbiter.records._session_store import this_boot
from end_effector_hal.arbiter.records._storage import FileStorage
from end_effector_hal.arbiter.rules._arbiter import LineArbiter
from end_effector_hal.arbiter.rules._lines import DROP_FIRST
from end_effector_hal.arbiter.rules._policy import Policy
from end_effector_hal.arbiter.server._connections import IDLE_US, MESSAGES, RANK, Connection, Connections
from end_effector_hal.arbiter.server._requests import RequestHandler, refusal
from end_effector_hal.errors import ArbiterError, UsageError, WireError
from end_effector_hal.owned import owned_folder
from end_effector_hal.wires import Claim, now_us
from end_effector_hal.wires.lines import LineBackend, RemoteLines
from end_effector_hal.wires.rpc import Listener, no_socket

_log = logging.getLogger("end_effector_hal.arbiter")


class OwnInputs(Protocol):
    """The input lines that the arbiter reads itself."""

    def fileno(self) -> int:
        """Return a file descriptor that is readable when there is news."""

    def read(self) -> Iterator[tuple[Mapping[str, bool], int]]:
        """Yield the predicates proven since the last call, with the times of the readings, µs."""

    @property
    def error(self) -> str:
        """Why the inputs cannot be read now, a sentence; empty: they are read."""

    def close(self) -> None:
        """Stop reading and release the inputs."""


class ArbiterServer(Closing):
    """Owns the lines of a back-end and executes the requests of clients; `protocol` describes the messages.

    Args:
        backend: the lines; they are not claimed yet.
        socket_path: path of the Unix socket (mode 0660). Its folder is created, and the socket of a dead arbiter is
            replaced.
        policy: the lines and their interlocks.
        journal: file that keeps latched faults through a power loss; None: no journal. The session record is a file
            beside the socket.
        group: the group whose members may open the socket; default: the group of the process.
        inputs: creates the inputs that the arbiter reads itself; called once it is certain that no other arbiter
            serves this path.

    Raises:
        LineBusyError: another arbiter serves this path, or another process has the lines; the message names it.
        LineNotFoundError, WireError: see `LineBackend.request`.
    """

    def __init__(
        self,
        backend: LineBackend,
        socket_path: str | Path,
        policy: Policy,
        journal: str | Path | None = None,
        *,
        group: str | None = None,
        inputs: Callable[[], OwnInputs] | None = None,
    ) -> None:
        self._path, self._backend = Path(socket_path), backend
        self._inputs: OwnInputs | None = None
        self._stops, self._stopped_at, self._grace_us = 0, 0, policy.lease_us
        self._waiting: dict[Connection, None] = {}  # that have sent more than they may in one round
        self._wake_read, self._wake = os.pipe()
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._wake_read, selectors.EVENT_READ)
        try:
            owned_folder(self._path.parent)
            self._claim = Claim(f"{self._path}.lock", "the socket of the line arbiter")
        except OSError as error:
            self._close_ends()
            if isinstance(error, WireError):
                raise
            raise no_socket(self._path.parent, error) from error
        try:
            if forgotten := recorded_left_behind(self._path, policy):
                raise UsageError(forgotten, todo=DROP_FIRST)
            self._records = _records(self._path, journal)
            before = self._records.before
            if not before.clean:
                _log.warning("the line arbiter before this one did not end in order")
            self._arbiter = LineArbiter(backend, policy, now_us(), before, self._records.before_change)
            self._records.keep(self._arbiter)
            self._inputs = inputs() if inputs else None
            listener = Listener(self._path, group)
        except BaseException:
            if self._inputs is not None:
                self._inputs.close()
            backend.close()
            self._claim.release()
            self._close_ends()
            raise
        if isinstance(backend, RemoteLines):
            for fd in backend.filenos():
                self._selector.register(fd, selectors.EVENT_READ, backend)
        if self._inputs is not None:
            self._selector.register(self._inputs.fileno(), selectors.EVENT_READ, self._inputs)
        self._connections = Connections(listener, self._selector)
        self._requests = RequestHandler(self._arbiter, self._records, self._drop)

    def levels(self) -> dict[str, bool]:
        """Return the levels of all lines as last written."""
        return dict(self._arbiter.levels)

    def faults(self) -> tuple[str, ...]:
        """Return the latched faults as sentences."""
        return tuple(self._arbiter.predicates.faults.values())

    def serve(self, on_ready: Callable[[ArbiterServer], None] = lambda _: None) -> None:
        """Run until SIGTERM, SIGINT or `stop`; ``on_ready`` is called first, as clients can connect."""
        before = {}
        if threading.current_thread() is threading.main_thread():
            before = {s: signal.signal(s, lambda *_: self.stop()) for s in (signal.SIGTERM, signal.SIGINT)}
        try:
            on_ready(self)
            self.run()
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    def run(self) -> None:
        """Serve until `stop`. A running last will is finished first; after that the lines keep their levels."""
        while not self._is_over():
            self.step(self._wait_s())

    def step(self, wait_s: float | None) -> None:
        """Do one round: answer messages for at most ``wait_s`` (None: until one arrives), then execute due actions."""
        self._serve(wait_s)
        at = now_us()
        if any(session.lease_until <= at and not session.ended for session in self._arbiter.sessions):
            # An arbiter that was stopped for a while first reads the renewals that came meanwhile.
            self._serve(0)
            self._end_leases(at)
        self._end(self._connections.idle(at), f"it was silent for {IDLE_US // 1_000_000} s")
        self._arbiter.advance(now_us())
        self._arbiter.written(now_us())
        self._records.keep(self._arbiter)

    def _serve(self, wait_s: float | None) -> None:
        """Answer messages once; their number per connection is limited, so that the others keep their leases."""
        ready, self._waiting = self._waiting, {}
        for key, _ in self._selector.select(wait_s):
            if type(key.data) is Connection:
                ready[key.data] = None
            elif key.fd == self._wake_read:
                self._stops += len(os.read(self._wake_read, 8))
                self._stopped_at = self._stopped_at or now_us()
            elif isinstance(key.data, RemoteLines):
                key.data.heard()
            elif key.data is None:
                self._end(self._connections.admit(), "there are too many connections")
        if self._inputs is not None:
            self._read_inputs(self._inputs)
        for connection in sorted(ready, key=RANK) if len(ready) > 1 else ready:
            self._answer(connection)

    def _read_inputs(self, inputs: OwnInputs) -> None:
        """Read the arbiter's own inputs; done before answering messages, because writes depend on them."""
        for proven, at in inputs.read():
            self._arbiter.predicates.read(proven, at)
        self._arbiter.predicates.unread = inputs.error

    def _is_over(self) -> bool:
        return self._stops > 1 or (self._stops == 1 and self._arbiter.may_end(self._stopped_at, now_us()))

    def _wait_s(self) -> float | None:
        if self._waiting:
            return 0
        at = now_us()
        due = min(filter(None, (self._arbiter.deadline, self._connections.due())), default=None)
        if self._stops and at < (end := self._stopped_at + self._grace_us):
            due = end if due is None else min(due, end)
        return None if due is None else max(0, due - at) / 1e6

    def stop(self) -> None:
        """End `run`; a second call ends it at once. May be called from any thread and from a signal handler."""
        os.write(self._wake, b"x")

    def close(self) -> None:
        """Release the lines, the socket and the records; call it after `run`."""
        self._connections.close()
        self._arbiter.end_pulses()
        state = self._arbiter.state
        if self._inputs is not None:
            self._inputs.close()
        self._backend.close()
        self._records.close(state, self._arbiter.policy)
        self._claim.release()
        self._close_ends()

    def _close_ends(self) -> None:
        self._selector.close()
        os.close(self._wake_read)
        os.close(self._wake)

    def _answer(self, connection: Connection) -> None:
        if connection.closed:  # it was dropped in this round
            return
        connection.receive()
        known = connection.session or connection.sends_predicates
        for _ in range(MESSAGES if known else MESSAGES // 4):
            line = connection.next_line()
            if line is None:
                break
            reply = self._requests.handle(connection, line)
            if connection.closed:
                return
            if reply is not None and not connection.put(write_message(reply)):
                self._drop(connection, "it does not read its replies")
                return
        if connection.waits:
            self._waiting[connection] = None
        elif connection.overlong:
            connection.put(write_message(refusal(None, UsageError("this message is too long."))))
            self._drop(connection, "its message was too long")
        elif connection.ended:
            self._drop(connection, "its socket was closed")

    def _drop(self, connection: Connection, why: str) -> None:
        if connection.closed:
            return
        self._connections.drop(connection)
        self._requests.left(connection)
        session, connection.session = connection.session, None
        if session and not session.ended:
            self._arbiter.declare_dead(session, why, now_us())

    def _end(self, connections: Iterable[Connection], why: str) -> None:
        """Close connections after sending the reason."""
        for connection in connections:
            error = ArbiterError(f"the line arbiter ends this connection: {why}.")
            connection.put(write_message(refusal(None, error)))
            self._drop(connection, why)

    def _end_leases(self, at: int) -> None:
        over = self._arbiter.expire(at)
        for connection in self._connections if over else ():
            if connection.session in over:
                error = ArbiterError(
                    "the lease expired: this client did not renew it, its last will is executed."
                )
                connection.put(write_message(refusal(None, error)))
                self._drop(connection, "its lease expired")


def _records(socket_path: Path, journal: str | Path | None) -> Records:
    boot = this_boot()
    disk = FileStorage(Path(journal), durable=True) if journal else None
    return Records(SessionStore.beside(socket_path), JournalThread(Journal(disk, boot, now_us)))
