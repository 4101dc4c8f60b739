"""Whether what was recorded is what happened on the wires."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path
from statistics import median

from end_effector_hal.description import Description
from end_effector_hal.recording import StatesLog
from end_effector_hal.wires.lines import ChipLog
from end_effector_hal.wires.lines import Edge as LineEdge
from end_effector_lab.virtual import Edge, Switching, switchings

from ._report import Finding

NEAR_MS = 250


def read_edges(path: Path) -> list[LineEdge]:
    """Everything that was written to a virtual chip, from its file."""
    return ChipLog().feed(path.read_bytes())


def on_the_wires(description: Description, log: StatesLog, edges: Iterable[LineEdge]) -> Finding:
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


def _recorded(log: StatesLog) -> list[Switching]:
    return [
        Switching(round(row.time_s * 1e6), name, new != 0)
        for before, row in pairwise(log.rows)
        for name, old, new in zip(log.actuators, before.actuators, row.actuators, strict=True)
        if (old != 0) != (new != 0)
    ]


def _seen(description: Description, edges: Iterable[LineEdge]) -> list[Switching]:
    """Those that change something: the first record of an output says only that it is driven."""
    active = dict.fromkeys(description.actuators, False)
    found = []
    for each in switchings(description, (Edge(edge.at, edge.line, edge.active) for edge in edges)):
        if each.active != active[each.name]:
            active[each.name] = each.active
            found.append(each)
    return found
