"""Whose time it is."""

from __future__ import annotations

import threading
from typing import Protocol

from end_effector_hal.wires import now_us

from ._inputs import LineInputs


class Clock(Protocol):
    """The time of the machine at the other end of the wires: what it sees of us happens in its own time."""

    def now_us(self) -> int:
        """Never running backwards."""
        ...

    def wait(self, stop: threading.Event, until: int) -> bool:
        """Wait until this µs; True: it is to stop, and may be earlier."""
        ...


class Monotonic:
    """This machine's: whoever is at the other end of real wires shares it."""

    def now_us(self) -> int:
        return now_us()

    def wait(self, stop: threading.Event, until: int) -> bool:
        return stop.wait(max(0.0, (until - now_us()) / 1e6))


def clock_of(inputs: LineInputs) -> Clock:
    """That of the machine whose lines these are: an emulated one has its own."""
    clock: Clock = getattr(inputs, "clock", None) or Monotonic()
    return clock
