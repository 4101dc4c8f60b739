"""The process of the page: its server, with the streams that it follows or the recordings that it shows."""

from __future__ import annotations

import asyncio
import errno
import os
import socket
from collections.abc import Callable, Coroutine, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import uvicorn
from starlette.types import ASGIApp
from uvicorn.protocols.http.h11_impl import H11Protocol

from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.page.link import TestbenchLink, ToolLink
from end_effector_hal.page.recorded import RecordedTables, RecordingFiles, RecordingPart
from end_effector_hal.page.view import FaultsView, ToolView
from end_effector_hal.wires import now_us

from ._app import make_app
from ._control import ControlLease, FaultCommands
from ._guard import PageAddress
from ._hub import Hub
from ._past import PastRecordings, step_back
from ._recordings import ServedRecording, make_recordings_app

MOST_CONNECTIONS = 64
LOOK_S = 1.0
REQUEST_S = 10.0
"""Time limit for a whole request."""
STALL_S = 30.0
"""Time limit for a client that reads nothing of its answer; longer, since the kernel buffers megabytes at once."""


class BoundedConnection(H11Protocol):
    """Extends uvicorn's protocol, which has a time-out between two requests but none within a request.

    Rule 1: A request must be complete in time, counted from the connection or from the answer before; otherwise its
        connection is closed, even if it arrives piece by piece.
    Rule 2: A client that reads nothing for that time is disconnected; a slow reader is not.
    Rule 3: If there are too many connections, the oldest one without a request being answered is closed.
    """

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Handle a new client."""
        super().connection_made(transport)
        self._begun = self._moved = self.loop.time()
        self._unsent = 0
        self._timer = self.loop.call_later(LOOK_S, self._look)
        self._make_room()

    def connection_lost(self, exc: Exception | None) -> None:
        """Handle the end of the connection."""
        self._timer.cancel()
        super().connection_lost(exc)

    def on_response_complete(self) -> None:
        """Prepare for the next request."""
        self._moved = self.loop.time()
        super().on_response_complete()

    def send_400_response(self, msg: str) -> None:
        """Refuse malformed data; close the connection if an answer has already begun."""
        if self.cycle is None or self.cycle.response_complete:
            super().send_400_response(msg)
            return
        self.cycle.disconnected = True
        self.cycle.message_event.set()
        self.transport.abort()

    @property
    def _answering(self) -> bool:
        cycle = self.cycle
        return cycle is not None and not cycle.more_body and not cycle.response_complete

    def _look(self) -> None:
        now, unsent = self.loop.time(), self.transport.get_write_buffer_size()
        if unsent < self._unsent or (self._answering and not unsent):
            self._moved = now
        self._unsent = unsent
        if now - self._moved > (STALL_S if unsent else REQUEST_S):
            self.transport.abort()
            return
        self._timer = self.loop.call_later(LOOK_S, self._look)

    def _make_room(self) -> None:
        every = [cast(BoundedConnection, each) for each in self.connections]
        there = [each for each in every if not each.transport.is_closing()]
        if len(there) > MOST_CONNECTIONS:
            waiting = [each for each in there if not each._answering and each is not self]
            min(waiting, key=lambda each: each._begun, default=self).transport.abort()


Ready = Callable[[str], None]


def serve_page(description: Description, address: PageAddress, recordings: Path, on_ready: Ready) -> None:
    """Serve the page of a tool until SIGINT or SIGTERM; its end moves no line.

    Args:
        description: the tool; its HAL need not run yet.
        address: address to serve at; port 0: any free port.
        recordings: folder of the recordings that the page lists; it need not exist yet.
        on_ready: receives the address with the token.

    Raises:
        UsageError: the address cannot be used.
        ModelError: the automata cannot be loaded.
    """

    async def live(address: PageAddress, listener: socket.socket) -> None:
        view, control = ToolView(description, now_us()), ControlLease()
        link, faults = ToolLink(description, view), FaultsView(description, view.log)
        testbench = TestbenchLink(description, faults)
        fault_commands = FaultCommands(testbench.ask, lambda: faults.there)
        hub = Hub(view, control, faults, fault_commands)
        past = PastRecordings(recordings, description.source)
        app = make_app(address, view, link.command, hub, control, fault_commands, past)
        beside = link.run(), testbench.run(), hub.run()

        def close() -> None:
            hub.close()
            past.close()

        await _serve(app, listener, lambda: on_ready(address.url), close, *beside)

    _listening(address, live)


def serve_recordings(
    files: Sequence[RecordingFiles | RecordedTables],
    part: RecordingPart,
    address: PageAddress,
    on_ready: Ready,
) -> None:
    """Serve the page of recordings until SIGINT or SIGTERM; it only reads files.

    Args:
        files: the files of one recording, or of two to compare.
        part: the part that is shown.
        address: address to serve at; port 0: any free port.
        on_ready: receives the address with the token.

    Raises:
        UsageError: the address cannot be used.
    """

    step_back(os.getpid())  # a tool may be running on this machine, and this process judges whole recordings

    async def recorded(address: PageAddress, listener: socket.socket) -> None:
        shown = [ServedRecording(each, part) for each in files]

        def close() -> None:
            for each in shown:
                each.cancel()

        app = make_recordings_app(address, shown)
        await _serve(app, listener, lambda: on_ready(address.url), close)

    _listening(address, recorded)


def _listening(
    address: PageAddress, run: Callable[[PageAddress, socket.socket], Coroutine[Any, Any, None]]
) -> None:
    listener = _listen(address)
    with listener:
        asyncio.run(run(replace(address, port=listener.getsockname()[1]), listener))


def _listen(address: PageAddress) -> socket.socket:
    try:
        family, *_, where = socket.getaddrinfo(address.host, address.port, type=socket.SOCK_STREAM)[0]
        return socket.create_server(where[:2], family=family)
    except (OSError, OverflowError, UnicodeError) as error:
        wrong_host = isinstance(error, socket.gaierror | UnicodeError) or error.args[:1] == (
            errno.EADDRNOTAVAIL,
        )
        todo = (
            "Give an address of this machine to --host."
            if wrong_host
            else "Name another --port, or --port 0 for one that is free."
        )
        what = getattr(error, "strerror", None) or error
        raise UsageError(
            f"The page cannot be served: {what}.", where=f"{address.host}:{address.port}", todo=todo
        ) from None


async def _serve(
    app: ASGIApp,
    listener: socket.socket,
    on_ready: Callable[[], None],
    close: Callable[[], None],
    *beside: Coroutine[Any, Any, None],
) -> None:
    """Run until the server or one of the parallel tasks ends."""
    server = uvicorn.Server(
        uvicorn.Config(
            app,
            log_level="error",  # what a stranger sends is no event
            access_log=False,
            server_header=False,
            lifespan="off",
            ws="none",
            timeout_graceful_shutdown=1,
            h11_max_incomplete_event_size=16_384,
            http=BoundedConnection,
        )
    )
    tasks = [asyncio.create_task(each) for each in beside]
    on_ready()
    served = asyncio.create_task(server.serve(sockets=[listener]))
    try:
        await asyncio.wait([served, *tasks], return_when=asyncio.FIRST_COMPLETED)
    finally:
        close()
        server.should_exit = True
        for task in tasks:
            task.cancel()
        for task in (*tasks, served):
            with suppress(asyncio.CancelledError, KeyboardInterrupt):
                await task
