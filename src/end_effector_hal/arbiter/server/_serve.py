"""The line arbiter as a process."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable
from pathlib import Path

from end_effector_hal.arbiter.rules import Policy
from end_effector_hal.arbiter.server._server import ArbiterServer
from end_effector_hal.wires.lines import LineBackend


def serve(
    backend: LineBackend,
    socket_path: str | Path,
    policy: Policy,
    *,
    journal: str | Path | None = None,
    group: str | None = None,
    on_ready: Callable[[ArbiterServer], None] | None = None,
) -> None:
    """Run the line arbiter until SIGTERM, SIGINT or `ArbiterServer.stop`; the lines stay as they are.

    Args:
        backend, socket_path, policy, journal, group: see `ArbiterServer`, also for the errors.
        on_ready: called once, when clients can come.
    """
    with ArbiterServer(backend, socket_path, policy, journal, group=group) as server:
        before = {}
        if threading.current_thread() is threading.main_thread():
            before = {s: signal.signal(s, lambda *_: server.stop()) for s in (signal.SIGTERM, signal.SIGINT)}
        try:
            if on_ready:
                on_ready(server)
            server.run()
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)
