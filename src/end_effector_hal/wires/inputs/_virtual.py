"""Digital inputs of a virtual chip; another process writes their levels into its file."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path

from end_effector_hal.description import DigitalInput
from end_effector_hal.errors import WireError
from end_effector_hal.wires._claim import Claim
from end_effector_hal.wires._clock import now_us
from end_effector_hal.wires.lines import ChipWatcher, Edge, VirtualChip
from end_effector_hal.wires.lines._backend import line_not_found

from ._lines import Edges, LineEdge

MOST_EDGES = 1024
"""Most edges that wait to be read; then the oldest are dropped, as in the kernel."""


class VirtualInputLines:
    """`InputLines` of a virtual chip. As in the kernel, a level is valid once it has lasted for ``debounce_ms``; of a
    line with ``poll_ms``, for that time.

    Args:
        path: the file of the chip.
        clock: µs; the clock of the processes that write into the file.
        reader: name of the reader; each reader has a claim of its own.
    """

    def __init__(
        self, path: str | Path, *, clock: Callable[[], int] = now_us, reader: str = "inputs"
    ) -> None:
        self._path, self._clock, self._reader = Path(path), clock, reader
        self._claim: Claim | None = None
        self._watcher: ChipWatcher | None = None
        self._came: deque[Edge] = deque(maxlen=MOST_EDGES)
        self._dropped = False
        self._debounce_us: dict[str, int] = {}
        self._levels: dict[str, bool] = {}
        self._pending: dict[str, LineEdge] = {}

    def request(self, inputs: Mapping[str, DigitalInput]) -> None:
        """Claim the inputs of this reader; see `InputLines.request`."""
        found = VirtualChip(self._path).read().lines
        if missing := [name for name in inputs if name not in found]:
            raise line_not_found(missing, list(found), looked_at=[str(self._path)])
        self._claim = Claim(f"{self._path}.{self._reader}.lock", "an input line of the virtual chip")
        self._debounce_us = {name: 1000 * (each.poll_ms or each.debounce_ms) for name, each in inputs.items()}
        self._came.clear()
        self._pending.clear()
        self._wake_read, self._wake = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
        self._watcher = ChipWatcher(self._path, self._seen)
        try:
            lines = self._watcher.start().lines
        except BaseException:
            self._watcher = None
            self._give_back()
            raise
        self._levels = {name: lines[name].level for name in inputs}

    def fds(self) -> list[int]:
        """Return the descriptor that is readable when there are edges."""
        return [self._wake_read] if self._watcher else []

    def due(self) -> int | None:
        """Return the time at which the next level will have lasted for its debounce time, µs."""
        return min((self._ripe(edge) for edge in self._pending.values()), default=None)

    def edges(self) -> Edges:
        """Return the new edges with the writer's time stamps plus the debounce time."""
        with suppress(BlockingIOError):
            os.read(self._wake_read, 4096)
        self._check()
        edges: list[LineEdge] = []
        while self._came:
            edge = self._came.popleft()
            if edge.line in self._levels:
                edges += self._settled(edge.at)
                edges += self._changed(LineEdge(edge.at, edge.line, edge.level))
        edges += self._settled(self._clock())
        lost, self._dropped = self._dropped, False
        if lost and self._watcher:
            now = self._watcher.state.lines
            self._levels = {name: now[name].level for name in self._levels if name in now}
        return Edges(edges, lost)

    def levels(self) -> dict[str, bool]:
        """Return the levels after the edges that were read."""
        self._check()
        return dict(self._levels)

    def close(self) -> None:
        """Release the lines."""
        watcher, self._watcher = self._watcher, None
        if watcher is not None:
            watcher.close()
            self._give_back()

    def _give_back(self) -> None:
        os.close(self._wake)
        os.close(self._wake_read)
        if self._claim:
            self._claim.release()
            self._claim = None

    def _check(self) -> None:
        if not self._path.exists():
            raise WireError(
                "the virtual chip has gone.",
                where=str(self._path),
                todo="Its inputs are read again as soon as it is back.",
            )

    def _seen(self, edge: Edge) -> None:
        """Queue an edge; called in the thread of the watcher."""
        self._dropped = self._dropped or len(self._came) == MOST_EDGES
        self._came.append(edge)
        with suppress(BlockingIOError):  # full: it is readable anyhow
            os.write(self._wake, b"e")

    def _changed(self, edge: LineEdge) -> Iterator[LineEdge]:
        if self._debounce_us[edge.line]:
            self._pending[edge.line] = edge
        elif self._levels[edge.line] != edge.high:
            self._levels[edge.line] = edge.high
            yield edge

    def _settled(self, until: int) -> Iterator[LineEdge]:
        """Yield the edges whose debounce time is over at ``until``, in the order in which it ended."""
        for edge in sorted(self._pending.values(), key=self._ripe):
            if self._ripe(edge) <= until:
                del self._pending[edge.line]
                if self._levels[edge.line] != edge.high:
                    self._levels[edge.line] = edge.high
                    yield edge._replace(at=self._ripe(edge))

    def _ripe(self, edge: LineEdge) -> int:
        return edge.at + self._debounce_us[edge.line]
