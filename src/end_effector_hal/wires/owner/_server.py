"""The line owner's process: one thread, one socket, one timer."""

from __future__ import annotations

import logging
import os
import selectors
import socket
import struct
from pathlib import Path
from typing import Any

from end_effector_hal.errors import EndEffectorError, OwnerError, UsageError, WireError
from end_effector_hal.wires._claim import Claim, program_name
from end_effector_hal.wires._clock import now_us
from end_effector_hal.wires.lines import LineBackend
from end_effector_hal.wires.owner._journal import Journal
from end_effector_hal.wires.owner._keeper import Keeper
from end_effector_hal.wires.owner._policy import Policy
from end_effector_hal.wires.owner._protocol import (
    LONGEST,
    Request,
    read_message,
    read_request,
    write_message,
)
from end_effector_hal.wires.owner._report import report
from end_effector_hal.wires.owner._session import Session, WillRunsError
from end_effector_hal.wires.owner._socket import listen, no_socket

_log = logging.getLogger("end_effector_hal.owner")
MOST_CLIENTS = 64


class _Connection:
    def __init__(self, sock: socket.socket) -> None:
        sock.setblocking(False)
        self.sock = sock
        self.pid = struct.unpack("3i", sock.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, 12))[0]
        self.rest = b""
        self.session: Session | None = None


class LineOwner:
    """Owns the lines of a back-end and serves them; see `_protocol` for the messages.

    Args:
        backend: not requested yet.
        socket_path: Unix socket (mode 0660); its directory is made, that of a dead owner replaced.
        policy: lines and interlocks.
        journal: file in which it remembers what the next one must know; None: it does not.
        group: whose members may open the socket; default: that of the process.

    Raises:
        LineBusyError: another owner lives at this path, or somebody else has the lines; says who.
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
    ) -> None:
        self._path, self._backend = Path(socket_path), backend
        self._stops, self._stopped_at, self._grace_us = 0, 0, policy.lease_us
        self._wake_read, self._wake = os.pipe()
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._wake_read, selectors.EVENT_READ)
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._claim = Claim(f"{self._path}.lock", "the line owner's socket")
        except OSError as error:
            self._close_ends()
            if isinstance(error, WireError):
                raise
            raise no_socket(self._path, error) from error
        try:
            self._journal = Journal(journal)
            before = self._journal.before
            self._keeper = Keeper(backend, policy, now_us(), before)
            if not before.clean:
                _log.warning("the line owner before this one did not end in order")
            self._journal.keep(self._keeper.memory)
            self._listener = listen(self._path, group)
        except BaseException:
            backend.close()
            self._claim.release()
            self._close_ends()
            raise
        self._selector.register(self._listener, selectors.EVENT_READ)

    def levels(self) -> dict[str, bool]:
        """Of all lines, as written last."""
        return dict(self._keeper.levels)

    def run(self) -> None:
        """Serve until `stop`; a will that runs is executed to its end, then the lines stay as they are."""
        while not self._is_over():
            self._serve(self._patience())
            at = now_us()
            if any(session.lease_until <= at and not session.ended for session in self._keeper.sessions):
                # An owner that was stopped for a while reads what came meanwhile first: it kills nobody.
                self._serve(0)
                self._end_leases(at)
            self._keeper.advance(now_us())
            self._journal.keep(self._keeper.memory)

    def _serve(self, wait_s: float | None) -> None:
        # What the sensors say comes first: it was sent before any write that follows from it.
        for key, _ in sorted(self._selector.select(wait_s), key=_writes):
            if key.fd == self._wake_read:
                self._stops += len(os.read(self._wake_read, 8))
                self._stopped_at = self._stopped_at or now_us()
            elif key.data is None:
                self._accept()
            else:
                self._receive(key.data)

    def _is_over(self) -> bool:
        if not self._stops:
            return False
        # who ends the owner often ends its clients, too, a moment later: what they leave is still done
        dying = now_us() < self._stopped_at + self._grace_us
        waits = any(session.ended or (dying and session.will) for session in self._keeper.sessions)
        return self._stops > 1 or not waits

    def _patience(self) -> float | None:
        at, due = now_us(), self._keeper.deadline
        if self._stops and at < (end := self._stopped_at + self._grace_us):
            due = end if due is None else min(due, end)
        return None if due is None else max(0, due - at) / 1e6

    def stop(self) -> None:
        """Ends `run`, the second time at once; may be called in any thread and in a signal handler."""
        os.write(self._wake, b"x")

    def close(self) -> None:
        """Give everything back, after `run`."""
        for key in list(self._selector.get_map().values()):
            if isinstance(key.data, _Connection):
                key.data.sock.close()
        self._listener.close()
        self._path.unlink(missing_ok=True)
        self._backend.close()
        self._journal.close()
        self._claim.release()
        self._close_ends()

    def __enter__(self) -> LineOwner:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _close_ends(self) -> None:
        self._selector.close()
        os.close(self._wake_read)
        os.close(self._wake)

    def _accept(self) -> None:
        try:
            sock, _ = self._listener.accept()
            if len(self._selector.get_map()) > MOST_CLIENTS:
                sock.close()
                return
            connection = _Connection(sock)
        except OSError as error:
            _log.warning("a client could not be accepted: %s", error)
            return
        self._selector.register(connection.sock, selectors.EVENT_READ, connection)

    def _receive(self, connection: _Connection) -> None:
        try:
            data = connection.sock.recv(LONGEST)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        *lines, connection.rest = (connection.rest + data).split(b"\n")
        for line in lines:
            if connection.sock.fileno() < 0:
                break
            reply = self._answer(connection, line)
            if reply is not None and not self._send(connection, reply):
                self._drop(connection, "it does not read its replies")
        if not data:
            self._drop(connection, "its socket was closed")
        elif len(connection.rest) > LONGEST:
            self._send(connection, _error(None, UsageError("this message is too long.")))
            self._drop(connection, "its message was too long")

    def _answer(self, connection: _Connection, line: bytes) -> dict[str, Any] | None:
        number = None
        try:
            message = read_message(line)
            number = message.get("id")
            request = read_request(message)
            more = self._do(connection, request)
            self._journal.keep(self._keeper.memory)  # before anybody is told
            if request.op == "tell" and number is None:
                return None
        except EndEffectorError as error:
            return _error(number, error) | {"levels": self._keeper.levels}
        except Exception:  # noqa: BLE001 the owner must outlive whatever a client sends
            _log.exception("a request of pid %d failed", connection.pid)
            return _error(number, OwnerError("the line owner failed at this request; its log says why."))
        return {"id": number, "ok": True, "error": None, "levels": self._keeper.levels} | more

    def _do(self, connection: _Connection, request: Request) -> dict[str, Any]:
        keeper, session, at = self._keeper, connection.session, now_us()
        if request.op == "status":
            return {
                "status": {
                    "pid": os.getpid(),
                    "unclean": not self._journal.before.clean,
                    **report(keeper, at),
                }
            }
        if request.op == "levels":
            return {"levels": self._backend.levels()}
        if request.op == "tell":
            keeper.sensed.tell(request.predicates, request.at_us, at)
            return {}
        if request.op == "latch":
            keeper.sensed.latch(request.fault, request.why)
            return {}
        if request.op == "reset":
            keeper.reset(at)
            return {}
        if request.op == "hello":
            if session:
                raise OwnerError(f"{session.client} has said hello already.")
            pid, will = connection.pid, request.will or ()
            program = program_name(pid) if pid else ""
            session = keeper.hello(
                request.client, request.token, request.lines, will, at, pid=pid, program=program
            )
            connection.session = session
            return {"overtaken": session.overtaken}
        if session is None:
            raise OwnerError("say hello first.")
        if request.op == "set":
            if request.until_us is not None and at > request.until_us:
                raise OwnerError("this write came too late and was not executed.")
            return {"delay_us": keeper.write(session, request.levels, request.will, at)}
        if request.op == "renew":
            keeper.renew(session, at)
            return {"faults": list(keeper.sensed.faults.values())}
        keeper.bye(session, request.will or (), at)
        connection.session = None
        return {}

    def _send(self, connection: _Connection, message: dict[str, Any]) -> bool:
        """Whether it went out whole; a client that lets its replies pile up does not live."""
        data = write_message(message)
        try:
            return connection.sock.send(data) == len(data)
        except OSError:
            return False

    def _drop(self, connection: _Connection, why: str) -> None:
        if connection.sock.fileno() < 0:
            return
        self._selector.unregister(connection.sock)
        connection.sock.close()
        session, connection.session = connection.session, None
        if session and not session.ended:
            self._keeper.dead(session, why, now_us())

    def _end_leases(self, at: int) -> None:
        over = self._keeper.expire(at)
        for key in list(self._selector.get_map().values()) if over else ():
            if isinstance(key.data, _Connection) and key.data.session in over:
                error = OwnerError("the lease ended: this client was not heard of, its will is executed.")
                self._send(key.data, _error(None, error))
                self._drop(key.data, "its lease ended")


def _writes(ready: tuple[selectors.SelectorKey, int]) -> bool:
    data = ready[0].data
    return isinstance(data, _Connection) and data.session is not None


def _error(number: object, error: EndEffectorError) -> dict[str, Any]:
    retry = {"retry_us": error.retry_us} if isinstance(error, WillRunsError) else {}
    return {"id": number, "ok": False, "error": str(error), "code": error.code, "levels": {}} | retry
