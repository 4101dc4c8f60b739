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
from typing import Any

import uvicorn
from starlette.types import ASGIApp

from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.page.link import TestbenchLink, ToolLink
from end_effector_hal.page.recorded import RecordedTables, RecordingFiles, RecordingPart
from end_effector_hal.page.view import FaultsView, ToolView
from end_effector_hal.wires import now_us

from ._app import make_app
from ._connection import BoundedConnection
from ._control import ControlLease, FaultCommands
from ._guard import PageAddress
from ._hub import Hub
from ._past import PastRecordings, step_back
from ._recordings import ServedRecording, make_recordings_app

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
