"""Missed reaction bounds, as moments of a figure."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import Moment, read_run

from ._load import ProgramTrace, load_trace, traces_of


def missed_moments(folder: str | Path) -> tuple[tuple[Moment, ...], tuple[str, ...]]:
    """The steps in the traces of a folder that were taken beyond their bound, in the time of its recording.

    Returns:
        Moments in order of time, and a note for each trace that cannot be read. Without traces, or where the
        recording does not say when it began: nothing.
    """
    start_us = read_run(folder).start_us
    moments: list[Moment] = []
    notes: list[str] = []
    for path in _traces(folder) if start_us is not None else ():
        try:
            moments += _of(load_trace(path), start_us or 0)
        except UsageError as error:
            notes.append(f"{error} Its missed bounds are not drawn.")
    return tuple(sorted(moments, key=lambda moment: moment.time_s)), tuple(notes)


def _traces(folder: str | Path) -> tuple[Path, ...]:
    try:
        return traces_of(folder)
    except UsageError:
        return ()


def _of(trace: ProgramTrace, start_us: int) -> Iterator[Moment]:
    for number, record in enumerate(trace.file.records):
        if record.kind == "step":
            step = trace.typed(number)
            if step.missed and step.at >= start_us:
                text = f"bound missed, {step.late_us / 1000:.0f} ms late"
                yield Moment((step.at - start_us) / 1_000_000, "missed", text)
