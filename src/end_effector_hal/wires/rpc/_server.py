"""A server with limits: it sends records to all clients and answers their requests."""

from __future__ import annotations

import logging
import queue
import selectors
import socket
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.wires._clock import now_us

from ._listener import Listener
from ._messages import Reply, RpcRequest, answer_line, read_message, refuse_late
from ._peers import Peer, Peers

_log = logging.getLogger("end_effector_hal.wires")
SECOND_US = 1_000_000
AGAIN_S = 0.1
WARN_EVERY_US = 10_000_000
"""Shortest time between two warnings about slow clients, µs, so that they do not fill the log."""
END_S = 1.0


@dataclass(frozen=True, slots=True)
class ClientLimits:
    """The limits of a server's clients."""

    clients: int = 16
    line: int = 1_000
    """Longest line of a client, bytes."""
    backlog: int = 2_000_000
    """Most bytes that may wait for a slow client."""
    rate: int = 100
    """Most lines of a client per second."""
    requests: int = 4
    """Most requests of one client that wait to be executed."""
    all_requests: int = 32
    """Most requests of all clients that wait to be executed, including clients that have disconnected meanwhile."""


class _Client(Peer):
    def __init__(self, sock: socket.socket, limits: ClientLimits, *, follows: bool) -> None:
        super().__init__(sock, limits.line, limits.backlog)
        self.follows = follows
        self.requests = 0  # that wait for their answer
        self._second = self._lines = 0

    def count_line(self, at: int) -> int:
        """Return the number of lines in this second, including this one."""
        if at - self._second >= SECOND_US:
            self._second, self._lines = at, 0
        self._lines += 1
        return self._lines


class Server:
    """Serves a socket, as described in the package. Only `wake` may be called from any thread.

    Args:
        path: the socket; one that was left behind is replaced.
        limits: the limits of its clients.
        group: the group whose members may connect; default: the group of the process.
        whose: owner of the socket, for error messages.
        greets: whether a client receives records only after a `begin`.
        request: type of the requests; None: lines of clients are ignored.
        handle: executes a request, in the thread of the requests; a UsageError refuses it.

    Raises:
        UsageError, WireError: see `Listener`.
    """

    def __init__(
        self,
        path: Path,
        limits: ClientLimits = ClientLimits(),
        group: str | None = None,
        *,
        whose: str = "the line arbiter",
        greets: bool = False,
        request: type[RpcRequest] | None = None,
        handle: Callable[[Any], Reply] = lambda request: Reply(False),
    ) -> None:
        self._path, self._limits, self._greets = path, limits, greets
        self._request, self._handle = request, handle
        self._ended = self._served = False
        self._warned: int | None = None  # µs, when the last slow client was reported
        self._requests: queue.SimpleQueue[tuple[_Client, RpcRequest] | None] = queue.SimpleQueue()
        self._answers: queue.SimpleQueue[tuple[_Client, bytes]] = queue.SimpleQueue()
        self._threads: list[threading.Thread] = []
        listener = Listener(path, group, whose=whose)
        self._selector = selectors.DefaultSelector()
        self._clients = Peers(
            listener, self._selector, lambda sock: _Client(sock, limits, follows=not greets)
        )
        # Sockets: one that is closed is never written to, while the number of a pipe may belong to something else then.
        self._wake_read, self._wake = socket.socketpair()
        self._wake.setblocking(False)
        self._selector.register(self._wake_read, selectors.EVENT_READ, self)

    def __len__(self) -> int:
        """Return the number of clients."""
        return len(self._clients)

    def fileno(self) -> int:
        """Return a descriptor that is readable when `poll` has work to do."""
        return self._selector.fileno()

    def start(self, name: str, turn: Callable[[], float | None]) -> None:
        """Serve in a thread until `close`.

        Args:
            name: the name of the thread.
            turn: called in the thread after each poll; returns how long the next poll may wait, s, None: until there
                is work.

        Raises:
            RuntimeError: no thread can be started; the server is closed.
        """
        threads: dict[str, Callable[[], None]] = {name: lambda: self._run(turn)}
        if self._request is not None:
            threads = {f"{name} requests": self._execute, **threads}
        try:
            for called, run in threads.items():
                thread = threading.Thread(target=run, name=called, daemon=True)
                thread.start()
                self._threads.append(thread)
        except RuntimeError:
            self.close()
            raise
        self._served = True

    def wake(self) -> None:
        """End the wait of `poll`."""
        with suppress(OSError):
            self._wake.send(b"x")

    def poll(self, wait_s: float | None = 0) -> None:
        """Serve for at most this time (None: until there is work), and send the answers that are ready."""
        for key, events in self._selector.select(wait_s):
            if isinstance(key.data, _Client):
                self._serve(key.data, events)
            elif key.data is self:
                self._wake_read.recv(4096)
            else:
                self._accept()
        while not self._answers.empty():
            client, line = self._answers.get()
            client.requests -= 1
            self._put(client, line)

    @property
    def has_newcomers(self) -> bool:
        """Whether a client waits for a `begin`."""
        return any(not client.follows for client in self._clients)

    def begin(self, data: bytes) -> None:
        """Send data to all newcomers; from now on they receive all records."""
        for client in self._clients:
            if not client.follows:
                client.follows = True
                self._put(client, data)

    def lose_all(self) -> None:
        """Treat all clients as newcomers again."""
        for client in self._clients:
            client.follows = False

    def send(self, data: bytes) -> None:
        """Send data to all clients except newcomers."""
        for client in self._clients:
            if client.follows:
                self._put(client, data)

    def close(self) -> None:
        """End all connections, and remove the socket."""
        if self._ended:
            return
        self._ended = True
        self._requests.put(None)
        self.wake()
        for thread in self._threads:
            if thread is not threading.current_thread():
                thread.join(END_S)
        if not self._served:
            self._shut()
        self._wake.close()

    def _shut(self) -> None:
        self._clients.close()
        self._selector.close()
        self._wake_read.close()

    def _run(self, turn: Callable[[], float | None]) -> None:
        wait_s: float | None = 0
        failure = ""
        while not self._ended:
            try:
                self.poll(wait_s)
                wait_s = turn()
            except Exception as error:  # noqa: BLE001 neither a lack of memory nor a bug ends this thread
                if (text := repr(error)) != failure:
                    failure = text
                    _log.exception("the socket %s is not served for a moment", self._path)
                if self._greets:
                    self.lose_all()
                time.sleep(AGAIN_S)
                wait_s = 0
        self._shut()

    def _accept(self) -> None:
        if (client := self._clients.accept()) is None or len(self._clients) <= self._limits.clients:
            return
        last = max(self._clients, key=lambda each: each.behind)
        self._clients.drop(last if last.behind else client)

    def _serve(self, client: _Client, events: int) -> None:
        if events & selectors.EVENT_WRITE and not client.closed:
            self._clients.send(client)
        if not events & selectors.EVENT_READ or client.closed:  # closed by what was served just before
            return
        client.receive()
        while (line := client.next_line()) is not None:
            if client.count_line(now_us()) > self._limits.rate:
                self._answer(client, None, f"More than {self._limits.rate} messages came within a second.")
                self._clients.drop(client)
                return
            self._take(client, line)
        if client.overlong or client.ended:
            self._clients.drop(client)

    def _take(self, client: _Client, line: bytes) -> None:
        if self._request is None:
            return
        try:
            request = read_message(self._request, line, "request")
        except UsageError as error:
            self._answer(client, None, str(error))
            return
        if client.requests >= self._limits.requests or self._requests.qsize() >= self._limits.all_requests:
            self._answer(client, request.id, "Too many requests are waiting: this one is not executed.")
            return
        client.requests += 1
        self._requests.put((client, request))

    def _answer(self, client: _Client, number: int | None, refused: str) -> None:
        self._put(client, answer_line(number, Reply(False, refused)))

    def _put(self, client: _Client, data: bytes) -> None:
        if self._clients.put(client, data) or client.behind <= self._limits.backlog:
            return  # sent, or the client has gone
        if self._warned is None or now_us() - self._warned >= WARN_EVERY_US:
            self._warned = now_us()
            _log.warning("a client of %s reads too slowly: it was disconnected", self._path)

    def _execute(self) -> None:
        while (entry := self._requests.get()) is not None:
            client, request = entry
            try:
                late = refuse_late(request.until_us)
                reply = Reply(False, late) if late else self._handle(request)
            except ReportedError as error:
                reply = Reply(False, str(error))
            except Exception:  # noqa: BLE001 the process goes on
                _log.exception("a request at %s failed", self._path)
                reply = Reply(False, "The request failed; the log has the reason.", decided=False)
            self._answers.put((client, answer_line(request.id, reply)))
            self.wake()
