"""The output lines in virtual time: what the arbiter writes moves the testbench, and outlives the arbiter."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple


class Edge(NamedTuple):
    """A line has changed at ``at`` µs."""

    at: int
    line: str
    level: bool


class VirtualOutputs:
    """A `LineBackend`.

    Args:
        names: of all lines of the board.
        active: those that are active at the start.
        clock: µs.
        on_edge: called with each change.
    """

    def __init__(
        self,
        names: Sequence[str],
        active: Mapping[str, bool],
        clock: Callable[[], int],
        on_edge: Callable[[Edge], None],
    ) -> None:
        self._levels = {name: active.get(name, False) for name in names}
        self._clock, self._on_edge = clock, on_edge

    def request(self, names: Sequence[str]) -> dict[str, bool]:
        """They keep their levels; see `LineBackend`."""
        return {name: self._levels[name] for name in names}

    def levels(self) -> dict[str, bool]:
        """As they stand."""
        return dict(self._levels)

    def set(self, levels: Mapping[str, bool]) -> None:
        """Write some of them, at once."""
        for name, level in levels.items():
            if self._levels[name] != level:
                self._levels[name] = level
                self._on_edge(Edge(self._clock(), name, level))

    def close(self) -> None:
        """They stay as they are."""
