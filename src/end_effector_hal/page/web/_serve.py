"""The process of the page: its server, and the streams that it follows."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

import uvicorn

from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.page.link import ToolLink
from end_effector_hal.page.view import ToolView
from end_effector_hal.wires import now_us

from ._address import PageAddress
from ._app import make_app
from ._control import ControlLease
from ._hub import Hub


def serve_page(description: Description, address: PageAddress, on_ready: Callable[[str], None]) -> None:
    """Serve the page of a tool until SIGINT or SIGTERM; no line moves when it ends.

    Args:
        description: the tool; its programs need not run yet.
        address: where; port 0: one that is free.
        on_ready: gets the address with the token.

    Raises:
        UsageError: the address cannot be used.
        ModelError: the automata cannot be loaded.
    """
    listener = _listen(address)
    with listener:
        address = replace(address, port=listener.getsockname()[1])
        asyncio.run(_run(description, address, listener, on_ready))


def _listen(address: PageAddress) -> socket.socket:
    try:
        family, *_, where = socket.getaddrinfo(address.host, address.port, type=socket.SOCK_STREAM)[0]
        return socket.create_server(where[:2], family=family)
    except (OSError, OverflowError) as error:
        todo = "Name another --port, or --port 0 for one that is free."
        what = getattr(error, "strerror", None) or error
        raise UsageError(
            f"The page cannot be served: {what}.", where=f"{address.host}:{address.port}", todo=todo
        ) from None


async def _run(
    description: Description,
    address: PageAddress,
    listener: socket.socket,
    on_ready: Callable[[str], None],
) -> None:
    view, control = ToolView(description, now_us()), ControlLease()
    link, hub = ToolLink(description, view), Hub(view, control)
    app = make_app(address, view, link.command, hub, control)
    server = uvicorn.Server(
        uvicorn.Config(
            app,
            log_level="warning",
            access_log=False,
            server_header=False,
            lifespan="off",
            ws="none",
            timeout_graceful_shutdown=1,
            h11_max_incomplete_event_size=16_384,
            limit_concurrency=64,
        )
    )
    tasks = [asyncio.create_task(link.run()), asyncio.create_task(hub.run())]
    on_ready(address.url)
    served = asyncio.create_task(server.serve(sockets=[listener]))
    try:
        await asyncio.wait([served, *tasks], return_when=asyncio.FIRST_COMPLETED)
    finally:
        hub.close()
        server.should_exit = True
        for task in tasks:
            task.cancel()
        for task in (*tasks, served):
            with suppress(asyncio.CancelledError, KeyboardInterrupt):
                await task
