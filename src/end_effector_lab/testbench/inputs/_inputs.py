"""Protocols for line inputs of the testbench, and for the clock of the machine that drives them."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Protocol

from end_effector_hal.wires import now_us

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
