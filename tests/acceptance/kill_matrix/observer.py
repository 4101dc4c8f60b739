"""Sees the output lines as a logic analyser would: it is none of the processes that are hit."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

from end_effector_hal.kinds.stanza import Opposite
from end_effector_hal.wires.lines import ChipWatcher, Edge, read_chip
from tests.acceptance.kill_matrix.waiting import until


class Change(NamedTuple):
    """An output, by its line, was switched at this time (µs)."""

    at: int
    line: str
    active: bool


class Observer:
    """Every change of every output since it began.

    An output with two coils goes where the coil drives it that becomes active, and stays there without power.

    Args:
        chip: path of the virtual chip.
        opposites: second coils, by the line of their output.

    Attributes:
        both_coils: outputs of which both coils were active together.
    """

    def __init__(self, chip: Path, opposites: Mapping[str, Opposite]) -> None:
        self._chip, self._lock = chip, threading.Lock()
        self._pairs = {line: each.line for line, each in opposites.items()}
        self._driven = {line: (line, True) for line in self._pairs}
        self._driven |= {second: (line, False) for line, second in self._pairs.items()}
        self.both_coils: set[str] = set()
        self._changes: list[Change] = []
        self._levels: dict[str, bool] = {}
        self._driven_to: dict[str, bool] = {}
        self._watcher = ChipWatcher(chip, self._saw)
        self._watcher.start()

    def mark(self) -> int:
        """This moment, for `since`: everything that stands in the chip's file now was before it."""
        wanted = read_chip(self._chip).lines
        until("the observer sees what is written", lambda: self._watcher.state.lines == wanted, 5.0)
        with self._lock:
            return len(self._changes)

    def since(self, mark: int, lines: Iterable[str]) -> list[tuple[str, bool]]:
        """Changes of the outputs on these lines since then."""
        wanted = set(lines)
        with self._lock:
            return [(each.line, each.active) for each in self._changes[mark:] if each.line in wanted]

    def first(self, mark: int) -> int | None:
        """µs of the first change since then, None: there is none."""
        with self._lock:
            return self._changes[mark].at if len(self._changes) > mark else None

    def active(self) -> set[str]:
        """Lines of the outputs that are active now: levels are read from the chip itself."""
        found = read_chip(self._chip).lines.items()
        levels = {line for line, state in found if state.direction == "out" and state.level}
        with self._lock:
            return levels - self._driven.keys() | {line for line, level in self._driven_to.items() if level}

    def close(self) -> None:
        """End."""
        self._watcher.close()

    def _saw(self, edge: Edge) -> None:
        with self._lock:
            self._levels[edge.line] = edge.active
            line, level = self._driven.get(edge.line, (edge.line, edge.active))
            if line in self._pairs:
                if self._levels.get(line) and self._levels.get(self._pairs[line]):
                    self.both_coils.add(line)
                if not edge.active or self._driven_to.get(line) is level:
                    return
                self._driven_to[line] = level
            self._changes.append(Change(edge.at, line, level))
