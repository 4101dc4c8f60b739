"""The output lines in virtual time: the arbiter's writes move the testbench and outlast the arbiter."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from end_effector_hal.description import Description


class Edge(NamedTuple):
    """A line changed at ``at`` µs."""

    at: int
    line: str
    level: bool


class Switching(NamedTuple):
    """The output of an actuator became active or inactive at ``at`` µs."""

    at: int
    name: str
    active: bool

    def __str__(self) -> str:
        return f"{self.name} {'on' if self.active else 'off'}"


def switchings(description: Description, edges: Iterable[Edge]) -> Iterator[Switching]:
    """Yield the switchings of actuators with one line, two coils or pulses; the last coil decides."""
    by_line = {actuator.line: name for name, actuator in description.ordered}
    second = {each.line: by_line[line] for line, each in description.opposites.items() if line in by_line}
    for edge in edges:
        if edge.line in second:
            if edge.level:
                yield Switching(edge.at, second[edge.line], False)
        elif (name := by_line.get(edge.line)) and (edge.level or edge.line not in description.opposites):
            yield Switching(edge.at, name, edge.level)


class VirtualOutputs:
    """A `LineBackend` whose lines exist only in virtual time.

    Args:
        names: names of all lines of the board.
        active: lines that are active at the start.
        clock: returns the time, µs.
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
        """Return the levels of the requested lines, which stay unchanged; see `LineBackend`."""
        return {name: self._levels[name] for name in names}

    def levels(self) -> dict[str, bool]:
        """Return the levels of all lines."""
        return dict(self._levels)

    def set(self, levels: Mapping[str, bool]) -> None:
        """Set the levels of some lines at once."""
        for name, level in levels.items():
            if self._levels[name] != level:
                self._levels[name] = level
                self._on_edge(Edge(self._clock(), name, level))

    def close(self) -> None:
        """Leave the lines as they are."""
