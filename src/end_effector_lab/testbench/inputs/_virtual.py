"""The protocols of line inputs and of their clock, and the inputs that read the lines of a virtual chip."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Protocol

from end_effector_hal.errors import LineNotFoundError, WireError
from end_effector_hal.wires import now_us
from end_effector_hal.wires.lines import ChipWatcher, Edge, Pull, VirtualChip, VirtualPins

OnEdge = Callable[[str, bool, int], None]
"""Callback with line, level, and time in µs; called in the thread of the inputs."""


class LineInputs(Protocol):
    """Reports every change of some lines by events."""

    @property
    def text(self) -> str:
        """Name of the inputs for people."""
        ...

    def start(self, on_edge: OnEdge) -> dict[str, bool]:
        """Start to report changes.

        Returns:
            The present levels; every later change becomes an edge.

        Raises:
            LineNotFoundError: a line is missing.
            WireError: the chip cannot be used.
        """
        ...

    def close(self) -> None:
        """Stop; no edge is reported after that."""
        ...


class Clock(Protocol):
    """The clock of the machine at the other end of the wires; all times in the testbench are times of this clock."""

    def now_us(self) -> int:
        """Return the time, µs; it never runs backwards."""
        ...

    def wait(self, stop: threading.Event, until: int) -> bool:
        """Wait until a time, µs; return True if ``stop`` is set, possibly earlier."""
        ...


class Monotonic:
    """This machine's monotonic clock, which both ends of real wires share."""

    def now_us(self) -> int:
        return now_us()

    def wait(self, stop: threading.Event, until: int) -> bool:
        return stop.wait(max(0.0, (until - now_us()) / 1e6))


def clock_of(inputs: LineInputs) -> Clock:
    """Return the clock of the machine that drives these lines; an emulated machine has its own."""
    clock: Clock = getattr(inputs, "clock", None) or Monotonic()
    return clock


class VirtualInputs:
    """Reads the lines of a virtual chip, which is made if there is none.

    The level of the pin counts, as on a board: an input that is pulled up reads as active.

    Args:
        path: the file of the chip.
        names: names of the lines.
        power_cycle: make a new chip even if there is one.
        pulled: further lines that the chip reads, with their pulls.
        levels: initial levels of those lines on a new chip.
    """

    def __init__(
        self,
        path: str | Path,
        names: Iterable[str],
        *,
        power_cycle: bool = False,
        pulled: Mapping[str, Pull] | None = None,
        levels: Mapping[str, bool] | None = None,
    ) -> None:
        self._path, self._names, self._power_cycle = Path(path), tuple(names), power_cycle
        self._pulled, self._levels = dict(pulled or {}), dict(levels or {})
        self._watcher: ChipWatcher | None = None
        self._pins = VirtualPins(self._path)

    @property
    def text(self) -> str:
        return f"virtual:{self._path}"

    def make_chip(self) -> VirtualChip:
        """Return the chip, made if there is none; raises WireError."""
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise WireError(
                f"the directory of the virtual chip cannot be made: {error.strerror}.",
                where=str(self._path),
                todo="Give another path.",
            ) from error
        return VirtualChip.create(
            self._path,
            [*self._names, *self._pulled],
            self._pulled,
            self._levels,
            exist_ok=not self._power_cycle,
        )

    def start(self, on_edge: OnEdge) -> dict[str, bool]:
        lines = self.make_chip().read().lines
        if missing := [name for name in (*self._names, *self._pulled) if name not in lines]:
            raise LineNotFoundError(
                f"the virtual chip has no line {', '.join(missing)}, only {', '.join(lines)}.",
                where=str(self._path),
                todo="It was made for another tool: give another path, or --power-cycle to make a new one.",
            )

        levels: dict[str, bool] = {}

        def seen(edge: Edge) -> None:
            # an input that becomes an inactive output is a record of the chip, and no change of the pin
            if edge.line in self._names and levels.get(edge.line) != edge.level:
                levels[edge.line] = edge.level
                on_edge(edge.line, edge.level, edge.at)

        self._watcher = ChipWatcher(self._path, seen)
        state = self._watcher.start()
        began = {name: state.lines[name].level for name in self._names}
        for name, level in began.items():
            levels.setdefault(name, level)  # an edge may have come already
        return began

    def show(self, name: str, level: bool) -> None:
        """Show the commanded output of a bus device as a line of the chip."""
        self._pins.drive({name: level}, "out")

    def close(self) -> None:
        self._pins.close()
        if self._watcher is not None:
            self._watcher.close()
