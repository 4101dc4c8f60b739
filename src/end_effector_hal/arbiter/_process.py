"""The line arbiter of a tool: its process, and the programs' connections to it."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, cast

from end_effector_hal.arbiter.client._client import ArbiterClient
from end_effector_hal.arbiter.server._server import ArbiterServer
from end_effector_hal.codecs import codec_of, line_of
from end_effector_hal.description import Description, socket_path
from end_effector_hal.errors import LineBusyError, UsageError
from end_effector_hal.signals import Frame
from end_effector_hal.wires import RELAYED, relay_path, tune_interpreter
from end_effector_hal.wires.inputs import InputsReader, input_lines, inputs_record, lines_of
from end_effector_hal.wires.lines import (
    ComposedLines,
    GpiodLines,
    LineBackend,
    LineHandover,
    RemoteLines,
    VirtualLines,
)
from end_effector_hal.wires.rpc import Server
from end_effector_hal.wires.sensors import FrameOrder

from ._predicate_publisher import PredicatePublisher
from ._service_manager import ServiceManager
from ._tool_policy import arbiter_policy, client_lines

if TYPE_CHECKING:
    from end_effector_hal.codecs.modbus import BusCodec

_MOST_WAITING = 256
_AGAIN_S = 0.1


def connect_arbiter(description: Description, client: str) -> ArbiterClient:
    """Connect ``hal`` or ``outputs`` to the line arbiter; raises ArbiterError, LineBusyError."""
    lines = client_lines(description, client)
    return ArbiterClient(socket_path(description), client, lines)


def run_arbiter(
    description: Description,
    socket: Path | None = None,
    journal: Path | None = None,
    group: str | None = None,
) -> None:
    """Run the line arbiter of a tool until SIGTERM or SIGINT; print a line when it is ready.

    A service manager is notified (sd_notify) when the arbiter is ready, and that it is alive as long as it answers
    over its own socket. The manager stores the claim of the lines while this process is replaced, so that no other
    process can claim them.

    Args:
        description: the tool.
        socket: path of the socket; default: from the description.
        journal: folder of the journal; default: the folder of the service manager (``$STATE_DIRECTORY``), else that of
            the socket.
        group: the group whose members may command the lines; default: the group of this process.

    Raises:
        WireError: the lines or the socket cannot be used.
    """

    def ready(server: ArbiterServer) -> None:
        # the levels on a bus without its port are unknown: the arbiter serves, but it is not ready
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
    own_inputs = partial(ArbiterInputs, description, relay_path(where, "inputs"), group)
    backend = _backend(description, where, group)
    with ServiceManager() as manager:
        if isinstance(backend, LineHandover):
            backend.restore(manager.stored_descriptors())
        with ArbiterServer(
            backend,
            where,
            arbiter_policy(description),
            _journal(where, journal),
            group=group,
            inputs=own_inputs if description.arbiter_inputs else None,
        ) as server:
            server.serve(ready)


def _journal(socket: Path, folder: Path | None) -> Path:
    """Return one file for each socket, so that the arbiters of two tools may share a folder."""
    state = os.environ.get("STATE_DIRECTORY", "").partition(":")[0]
    return (folder or Path(state or socket.parent)) / f"{socket.name}.journal"


class _Probe:
    """Read the levels as a client does: through the socket, the loop and the hardware."""

    def __init__(self, where: Path) -> None:
        self._where = where
        self._client: ArbiterClient | None = None

    def __call__(self) -> None:
        # connect in the thread of the watchdog: before the loop runs there is no answer
        self._client = self._client or ArbiterClient(self._where, "watchdog", patience_s=0)
        self._client.levels()


def _backend(description: Description, socket: Path, group: str | None) -> LineBackend:
    """Return the lines of the board together with the registers of devices, one bus for each link."""
    if not description.buses:
        return _board_lines(description)
    from end_effector_hal.wires.bus import BusLines, BusLink, bus_relay

    others: dict[str, BusLines] = {}
    for name, outputs in description.buses.items():
        link, codec = description.links[name], codec_of(description, name)
        bus = BusLink(link.port, cast("BusCodec", codec), *line_of(link, codec))
        lines = BusLines(bus, outputs, bus_relay(description, socket, name), group, description.release_us)
        others |= dict.fromkeys(outputs, lines)
    return ComposedLines(_board_lines(description), others)


def _board_lines(description: Description) -> LineBackend:
    if description.lines.backend == "gpiod":
        return GpiodLines(inputs=tuple(input_lines(description)))
    if description.lines.path is None:
        raise UsageError(
            "virtual lines need a file for the chip.",
            where=description.where("lines"),
            todo="Add path: to lines.",
        )
    return VirtualLines(description.lines.path)


class ArbiterInputs:
    """Input lines on which interlocks rest: the arbiter reads them itself and relays them to the programs.

    This is an `OwnInputs`. One thread reads the lines, another one relays every frame; neither waits for the arbiter.
    Lines that another process holds are requested again and again; until they are free they prove nothing.

    Args:
        description: the tool; it has `arbiter_inputs`.
        relay: path of the socket that relays every frame.
        group: its members may read there; default: the group of the process.

    Raises:
        WireError: the relay cannot be made.
    """

    def __init__(self, description: Description, relay: Path, group: str | None = None) -> None:
        self._relay = Server(relay, RELAYED, group)
        self._proven: deque[tuple[Mapping[str, bool], int]] = deque(maxlen=_MOST_WAITING)
        self._records: deque[bytes] = deque(maxlen=_MOST_WAITING)
        self._news_read, self._news = os.pipe2(os.O_CLOEXEC | os.O_NONBLOCK)
        self._ended, self._busy = False, ""
        self._order = FrameOrder()
        self._publisher = PredicatePublisher(description, sender=self)
        mine, lines = description.with_inputs(description.arbiter_inputs), lines_of(description, "arbiter")
        self._reader = InputsReader(mine, self._on_frame, lines=lines)
        self._started = False
        self._relay.start("own inputs", self._turn)
        self._publisher.start()

    def fileno(self) -> int:
        """See `OwnInputs`."""
        return self._news_read

    def read(self) -> Iterator[tuple[Mapping[str, bool], int]]:
        """See `OwnInputs`."""
        with suppress(BlockingIOError):
            os.read(self._news_read, 4096)
        while self._proven:
            yield self._proven.popleft()

    @property
    def error(self) -> str:
        """See `OwnInputs`."""
        return self._busy or self._reader.health.error

    def send(self, predicates: Mapping[str, bool], at_us: int) -> bool:
        """Queue predicates for the arbiter; while the lines cannot be read, only predicates that do not hold."""
        if failing := bool(self.error):
            predicates = {name: holds for name, holds in predicates.items() if not holds}
        if predicates:
            self._proven.append((predicates, at_us))
            with suppress(BlockingIOError):
                os.write(self._news, b"x")
        return not failing

    def close(self) -> None:
        """Release the lines."""
        if self._ended:
            return
        self._ended = True
        self._relay.close()
        self._reader.close()
        self._publisher.close()

    def _on_frame(self, frame: Frame) -> None:
        # an edge can arrive before the levels that were read just before it
        self._publisher.frame(self._order.next(frame), self._queue)

    def _queue(self, frame: Frame) -> None:
        self._records.append(inputs_record(frame))
        self._relay.wake()

    def _turn(self) -> float | None:
        """Start to read as soon as the lines are free, and relay the frames that were read."""
        self._started = self._started or self._start()
        while self._records:
            self._relay.send(self._records.popleft())
        return None if self._started else _AGAIN_S

    def _start(self) -> bool:
        """Return whether the lines are read; another process may hold them now and end later."""
        try:
            self._reader.start(patience_s=0)
        except LineBusyError as error:
            self._busy = str(error)
            return False
        self._busy = ""
        return True
