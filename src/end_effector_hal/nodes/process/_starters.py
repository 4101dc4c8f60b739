"""What waits until all nodes of a process are there: the frames."""

from __future__ import annotations

from collections.abc import Callable

from end_effector_hal.wires import tune_interpreter


class Starters:
    """Calls back once all is made, after the memory was tidied: that takes so long that readings would turn stale."""

    def __init__(self) -> None:
        self._first: list[Callable[[], None]] = []
        self._last: list[Callable[[], None]] = []

    def add(self, callback: Callable[[], None], *, last: bool = False) -> None:
        """Call ``callback`` then, in the order of registration; ``last``: behind all others."""
        (self._last if last else self._first).append(callback)

    def start(self) -> None:
        """All nodes are there."""
        tune_interpreter()
        for callback in (*self._first, *self._last):
            callback()
