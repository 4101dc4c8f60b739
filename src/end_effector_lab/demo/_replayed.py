"""Whether the traces of a run decide the same once more, and are runs of the network."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from end_effector_hal.errors import ReportedError
from end_effector_hal.verification.replay import Review, SegmentEnd, load_trace, review, traces_of

from ._finding import Finding

EXPECTED = "the same decisions, and a run of the network"


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
