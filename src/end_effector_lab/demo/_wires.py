"""Whether what was recorded is what happened on the wires."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import NamedTuple

from end_effector_hal.description import Description
from end_effector_hal.recording import StatesLog
from end_effector_hal.wires.lines import ChipLog, Edge

from ._report import Finding


class Switch(NamedTuple):
    """An actuator was switched; µs on any clock."""

    at: int
    actuator: str
    active: bool

    def __str__(self) -> str:
        return f"{self.actuator} {'on' if self.active else 'off'}"


NEAR_MS = 250


def read_edges(path: Path) -> list[Edge]:
    """Everything that was written to a virtual chip, from its file."""
    return ChipLog().feed(path.read_bytes())


def on_the_wires(description: Description, log: StatesLog, edges: Iterable[Edge]) -> Finding:
    """Each activation and deactivation of the recording has its edge, near its time, and no other.

    The two have different clocks; the median of the differences stands between them. How late an edge is, the
    executor reports; here it is enough that the two tell the same, on a busy machine, too.
    """
    recorded, seen = _recorded(log), _seen(description, edges)
    expected, found = ", ".join(map(str, recorded)) or "no edge", ", ".join(map(str, seen)) or "no edge"
    if expected != found:
        return Finding("wires", expected, found, ok=False)
    late_us = [edge.at - row.at for row, edge in zip(recorded, seen, strict=True)]
    worst_ms = max((abs(each - median(late_us)) / 1000 for each in late_us), default=0.0)
    what = f"each edge within {NEAR_MS} ms of its row"
    return Finding("wires", what, f"one {worst_ms:.1f} ms off", ok=worst_ms <= NEAR_MS)


def _recorded(log: StatesLog) -> list[Switch]:
    return [
        Switch(round(row.time_s * 1e6), name, new != 0)
        for before, row in pairwise(log.rows)
        for name, old, new in zip(log.actuators, before.actuators, row.actuators, strict=True)
        if (old != 0) != (new != 0)
    ]


def _seen(description: Description, edges: Iterable[Edge]) -> list[Switch]:
    lines = {actuator.line: name for name, actuator in description.ordered}
    pulsed = {line: each.line for line, each in description.opposites.items() if each.pulse_s is not None}
    back = {opposite: lines[line] for line, opposite in pulsed.items() if line in lines}
    active = dict.fromkeys(lines.values(), False)
    found = []
    for edge in edges:
        name = lines.get(edge.line) or back.get(edge.line)
        if name is None or (not edge.active and (edge.line in back or edge.line in pulsed)):
            continue  # the end of a pulse moves nothing
        level = edge.active and edge.line not in back
        if level != active[name]:
            active[name] = level
            found.append(Switch(edge.at, name, level))
    return found
