"""Sees the output lines as a logic analyser would: it is none of the processes that are hit."""

from __future__ import annotations

import threading
from collections.abc import Iterable
from pathlib import Path

from end_effector_hal.wires.lines import ChipWatcher, Edge, read_chip
from tests.acceptance.kill_matrix.waiting import until


class Observer:
    """Every change of every line since it began."""

    def __init__(self, chip: Path) -> None:
        self._chip, self._lock = chip, threading.Lock()
        self._edges: list[Edge] = []
        self._watcher = ChipWatcher(chip, self._saw)
        self._watcher.start()

    def mark(self) -> int:
        """This moment, for `since`: everything that stands in the chip's file now was before it."""
        wanted = read_chip(self._chip).lines
        until("the observer sees what is written", lambda: self._watcher.state.lines == wanted, 5.0)
        with self._lock:
            return len(self._edges)

    def since(self, mark: int, lines: Iterable[str]) -> list[tuple[str, bool]]:
        """Changes of these lines since then."""
        wanted = set(lines)
        with self._lock:
            return [(edge.line, edge.active) for edge in self._edges[mark:] if edge.line in wanted]

    def first(self, mark: int) -> int | None:
        """µs of the first change since then, None: there is none."""
        with self._lock:
            return self._edges[mark].at if len(self._edges) > mark else None

    def active(self) -> set[str]:
        """Lines that are active now, read from the chip itself."""
        found = read_chip(self._chip).lines.items()
        return {line for line, state in found if state.direction == "out" and state.level}

    def close(self) -> None:
        """End."""
        self._watcher.close()

    def _saw(self, edge: Edge) -> None:
        with self._lock:
            self._edges.append(edge)
