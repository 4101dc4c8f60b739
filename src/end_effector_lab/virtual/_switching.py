"""Outputs that were switched, whatever lines that takes: one, two coils, or pulses."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from end_effector_hal.description import Description

from ._outputs import Edge


class Switching(NamedTuple):
    """The output of an actuator became active, or inactive, at ``at`` µs."""

    at: int
    name: str
    active: bool

    def __str__(self) -> str:
        return f"{self.name} {'on' if self.active else 'off'}"


def switchings(description: Description, edges: Iterable[Edge]) -> Iterator[Switching]:
    """Those of the actuators; an output of two coils stays as the last coil has left it."""
    by_line = {part.line: name for name, part in description.ordered}
    second = {each.line: by_line[line] for line, each in description.opposites.items() if line in by_line}
    for edge in edges:
        if edge.line in second:
            if edge.level:
                yield Switching(edge.at, second[edge.line], False)
        elif (name := by_line.get(edge.line)) and (edge.level or edge.line not in description.opposites):
            yield Switching(edge.at, name, edge.level)
