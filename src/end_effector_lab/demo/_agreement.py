"""Whether a recording agrees with what happened: on the wires, in the answers, and by the automata."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import pairwise
from pathlib import Path
from statistics import median

from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError
from end_effector_hal.recording import StatesLog
from end_effector_hal.verification.replay import Review, SegmentEnd, load_trace, review, traces_of
from end_effector_hal.wires.lines import ChipLog
from end_effector_hal.wires.lines import Edge as LineEdge
from end_effector_lab.virtual import Edge, Switching, switchings

from ._report import Finding

NEAR_MS = 250
TAKEN = "every command taken"
REPLAYED = "identical decisions, every step allowed by the automata"


def read_edges(path: Path) -> list[LineEdge]:
    """Return everything that was written to a virtual chip, from its file."""
    return ChipLog().feed(path.read_bytes())


def on_the_wires(description: Description, log: StatesLog, edges: Iterable[LineEdge]) -> Finding:
    """Compare the edges on the wires with the recording: the same ones, near their times.

    The two have different clocks; the median of the differences is taken as their offset. The executor reports how
    late an edge is; the limit here is wide enough for a busy machine, and for a device that is activated first.
    """
    recorded, seen = _recorded(log), _seen(description, edges)
    expected, found = ", ".join(map(str, recorded)) or "no edge", ", ".join(map(str, seen)) or "no edge"
    if expected != found:
        return Finding("wires", expected, found, ok=False)
    late_us = [edge.at - row.at for row, edge in zip(recorded, seen, strict=True)]
    worst_ms = max((abs(each - median(late_us)) / 1000 for each in late_us), default=0.0)
    outputs = description.register_outputs.values()
    near_ms = NEAR_MS + max(
        (each.activation.ready_within_s * 1000 for each in outputs if each.activation), default=0
    )
    what = f"each edge within {near_ms:g} ms of its row"
    return Finding("wires", what, f"one {worst_ms:.1f} ms off", ok=worst_ms <= near_ms)


def _recorded(log: StatesLog) -> list[Switching]:
    return [
        Switching(round(row.time_s * 1e6), name, new != 0)
        for before, row in pairwise(log.rows)
        for name, old, new in zip(log.actuators, before.actuators, row.actuators, strict=True)
        if (old != 0) != (new != 0)
    ]


def _seen(description: Description, edges: Iterable[LineEdge]) -> list[Switching]:
    """Return the edges that change something: the first record of an output shows only that it is driven."""
    active = dict.fromkeys(description.actuators, False)
    found = []
    for each in switchings(description, (Edge(edge.at, edge.line, edge.active) for edge in edges)):
        if each.active != active[each.name]:
            active[each.name] = each.active
            found.append(each)
    return found


def answered(folder: Path) -> Finding:
    """Report every command that was refused, with the reason that the client got."""
    try:
        refused = [each for path in traces_of(folder) for each in _refused(path)]
    except (ReportedError, KeyError) as error:
        refused = [str(error)]
    return Finding("answers", TAKEN, "; ".join(refused) or TAKEN, not refused)


def _refused(path: Path) -> Iterator[str]:
    command, trace = "", load_trace(path)
    for number, record in enumerate(trace.file.records):
        if record.kind == "command":
            command = str(trace.content(number)["name"])
        elif record.kind == "answer" and not (answer := trace.content(number))["accepted"]:
            yield f"{command} was refused: {answer['reason']}"


def replayed(folder: Path) -> Finding:
    """Replay the trace of a run, and have the monitor judge it."""
    try:
        faults = list(_all_faults(folder))
    except ReportedError as error:
        faults = [str(error)]
    return Finding("replay", REPLAYED, "; ".join(faults) or REPLAYED, not faults)


def _all_faults(folder: Path) -> Iterator[str]:
    before: SegmentEnd | None = None
    for path in traces_of(folder):
        found = review(load_trace(path), before=before)
        before = found.end
        yield from _faults(found)


def _faults(found: Review) -> Iterator[str]:
    name, seconds = found.trace.file.path.name, found.trace.seconds
    if found.replay.difference is not None:
        yield f"{name} at {seconds(found.replay.difference.at):.3f} s: {found.replay.difference}"
    for objection in found.objections:
        if objection.kind != "missed":
            yield f"{name} at {seconds(objection.at):.3f} s: {objection.what}"
