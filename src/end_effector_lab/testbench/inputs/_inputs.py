"""Where the testbench sees the lines, and whose time it is there."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Protocol

from end_effector_hal.wires import now_us

OnEdge = Callable[[str, bool, int], None]
"""Line, level, µs: called in the thread of the inputs."""


class LineInputs(Protocol):
    """Tells of every change of some lines, by events."""

    @property
    def text(self) -> str:
        """What they are, for people."""
        ...

    def start(self, on_edge: OnEdge) -> dict[str, bool]:
        """Begin.

        Returns:
            The levels; every later change becomes an edge.

        Raises:
            LineNotFoundError: a line is missing.
            WireError: the chip cannot be used.
        """
        ...

    def close(self) -> None:
        """End; no edge comes after it."""
        ...


class Clock(Protocol):
    """The time of the machine at the other end of the wires: what it sees of us happens in its own time."""

    def now_us(self) -> int:
        """Never running backwards."""
        ...

    def wait(self, stop: threading.Event, until: int) -> bool:
        """Wait until this µs; True: it is to stop, and may be earlier."""
        ...


class Monotonic:
    """This machine's clock: both ends of real wires share it."""

    def now_us(self) -> int:
        return now_us()

    def wait(self, stop: threading.Event, until: int) -> bool:
        return stop.wait(max(0.0, (until - now_us()) / 1e6))


def clock_of(inputs: LineInputs) -> Clock:
    """That of the machine whose lines these are: an emulated one has its own."""
    clock: Clock = getattr(inputs, "clock", None) or Monotonic()
    return clock
