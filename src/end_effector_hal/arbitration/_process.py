"""The line arbiter of a tool: its process, and the connections of the programs to it."""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, cast

from end_effector_hal.arbiter import ArbiterClient, ArbiterServer, serve
from end_effector_hal.codecs import codec_of, line_of
from end_effector_hal.description import Description, socket_path
from end_effector_hal.errors import UsageError
from end_effector_hal.wires import relay_path, tune_interpreter
from end_effector_hal.wires.lines import (
    ComposedLines,
    GpiodLines,
    LineBackend,
    LineHandover,
    RemoteLines,
    VirtualLines,
)

from ._own_inputs import ArbiterInputs
from ._policy import arbiter_policy, written_lines
from ._service_manager import ServiceManager

if TYPE_CHECKING:
    from end_effector_hal.codecs.modbus import BusCodec


def connect_arbiter(description: Description, program: str, *, patience_s: float = 5.0) -> ArbiterClient:
    """Connect one program to the line arbiter; raises ArbiterError, LineBusyError."""
    lines = written_lines(description, program)
    return ArbiterClient(socket_path(description), program, lines, patience_s=patience_s)


def run_arbiter(
    description: Description,
    socket: Path | None = None,
    journal: Path | None = None,
    group: str | None = None,
) -> None:
    """Run the line arbiter of a tool until SIGTERM or SIGINT; prints when it is ready.

    A service manager is notified as well (sd_notify): that the arbiter is ready, and that it lives as long as it
    gets an answer over its own socket. The manager stores the claim of the lines while this process is replaced, so
    that no other process can claim them.

    Args:
        description: the tool.
        socket: path to serve; default: that of the description.
        journal: folder of the journal; default: that of the service manager (``$STATE_DIRECTORY``), else that of the
            socket.
        group: its members may command the lines; default: the group of this process.

    Raises:
        WireError: the lines or the socket cannot be used.
    """

    def ready(server: ArbiterServer) -> None:
        # of what a bus without its port drives nothing is known: that is no readiness, though clients are served
        missing = backend.troubles() if isinstance(backend, RemoteLines) else {}
        levels = [f"{line}={int(level)}" for line, level in server.levels().items() if line not in missing]
        unknown = [f"{line} {why}" for line, why in sorted(missing.items())]
        latched = "".join(f"; latched: {why.rstrip('.')}" for why in server.faults())
        word, said = "serving" if missing else "ready", ", ".join([*levels, *unknown])
        print(f"{word}: {description.name} on {where}: {said}{latched}", flush=True)  # noqa: T201 its output
        manager.store(backend.descriptors() if isinstance(backend, LineHandover) else {})
        manager.ready(f"{description.name} on {where}", _Probe(where))
        tune_interpreter()

    where = socket or socket_path(description)
    backend = _backend(description, where, group)
    with ServiceManager() as manager:
        if isinstance(backend, LineHandover):
            backend.restore(manager.stored_descriptors())
        serve(
            backend,
            where,
            arbiter_policy(description),
            journal=_journal(where, journal),
            group=group,
            inputs=partial(_own_inputs, description, where, group) if description.arbiter_inputs else None,
            on_ready=ready,
        )


def _journal(socket: Path, folder: Path | None) -> Path:
    """One file for each socket, so that the arbiters of two tools may share a folder."""
    state = os.environ.get("STATE_DIRECTORY", "").partition(":")[0]
    return (folder or Path(state or socket.parent)) / f"{socket.name}.journal"


class _Probe:
    """Reads the levels as any client does: the answer went through the socket, the loop and the hardware."""

    def __init__(self, where: Path) -> None:
        self._where = where
        self._client: ArbiterClient | None = None

    def __call__(self) -> None:
        # in the thread of the watchdog: before the loop runs it would get no answer
        self._client = self._client or ArbiterClient(self._where, "watchdog", patience_s=0)
        self._client.levels()


def _own_inputs(description: Description, socket: Path, group: str | None) -> ArbiterInputs:
    return ArbiterInputs(description, relay_path(socket, "inputs"), group)


def _backend(description: Description, socket: Path, group: str | None) -> LineBackend:
    """The lines of the board, and the registers of devices on the links, each bus by itself."""
    if not description.buses:
        return _board_lines(description)
    from end_effector_hal.wires.bus import BusLines, BusLink, bus_relay

    others: dict[str, BusLines] = {}
    for name, outputs in description.buses.items():
        link, codec = description.links[name], codec_of(description, name)
        bus = BusLink(link.port, cast("BusCodec", codec), *line_of(link, codec))
        lines = BusLines(bus, outputs, bus_relay(description, socket, name), group)
        others |= dict.fromkeys(outputs, lines)
    return ComposedLines(_board_lines(description), others)


def _board_lines(description: Description) -> LineBackend:
    if description.lines.backend == "gpiod":
        return GpiodLines()
    if description.lines.path is None:
        raise UsageError(
            "virtual lines need a file for the chip.",
            where=description.where("lines"),
            todo="Add path: to lines.",
        )
    return VirtualLines(description.lines.path)
