"""What the traces of a run say: every command was taken, and they are runs of the network."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from end_effector_hal.errors import ReportedError
from end_effector_hal.verification.replay import Review, SegmentEnd, load_trace, review, traces_of

from ._report import Finding

TAKEN = "every command taken"


def answered(folder: Path) -> Finding:
    """Every command that its program refused, with the reason in the words that a client got."""
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


EXPECTED = "identical decisions, every step allowed by the automata"


def replayed(folder: Path) -> Finding:
    """Both programs of a run, replayed and judged by the monitor."""
    try:
        faults = list(_all_faults(folder))
    except ReportedError as error:
        faults = [str(error)]
    return Finding("replay", EXPECTED, "; ".join(faults) or EXPECTED, not faults)


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
