"""A recording for figures: read from its folder, drawn in a style."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Self

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import Moment, RunTables, read_run
from end_effector_hal.verification.replay import ProgramTrace, load_trace, traces_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STYLES = ("timeline", "paper")


@dataclass(frozen=True)
class RecordedRun(RunTables):
    """All data of a recording that figures show.

    Attributes:
        missed: decisions of the monitor that the program did not make.
        notes: sentences about data that could not be read.
        marks: additional moments to show.
    """

    missed: Sequence[Moment] = ()
    notes: tuple[str, ...] = ()
    marks: Sequence[Moment] = ()

    @classmethod
    def read(cls, states: Path, faults: list[str] | None = None) -> Self:
        """Read ``states.csv`` and the files beside it; raises UsageError if the states cannot be read.

        Damaged pressures, and traces that cannot be read, do not prevent the figure of the states.
        """
        faults = [] if faults is None else faults
        run = super().read(states, faults)
        damaged = [f"{fault} The pressures are not drawn." for fault in faults]
        missed, unread = missed_moments(states.parent)
        cut_off = run.pressures.note if run.pressures else ""
        notes = (run.log.note, run.info.note, *run.info.gaps, cut_off, *damaged, *unread)
        return replace(run, missed=missed, notes=tuple(filter(None, notes)))

    def figure(self, style: str) -> Figure:
        """Draw the run in one of `STYLES`; raises UsageError for a recording without a row."""
        if style == "paper":
            from ._paper import paper

            return paper(self.log, self.info)
        from ._timeline import timeline

        marks = (*self.missed, *self.marks)
        return timeline(self.log, self.pressures, self.info, self.alarms, marks, self.changer, self.switches)


def missed_moments(folder: str | Path) -> tuple[tuple[Moment, ...], tuple[str, ...]]:
    """Return the steps in the traces of a folder that missed their bound, in the time of its recording.

    Returns:
        Moments in order of time, and a note for each trace that cannot be read. Both are empty without traces, or if
        the recording has no start time.
    """
    start_us = read_run(folder).start_us
    moments: list[Moment] = []
    notes: list[str] = []
    for path in _traces(folder) if start_us is not None else ():
        try:
            moments += _missed_steps(load_trace(path), start_us or 0)
        except UsageError as error:
            notes.append(f"{error} Its missed bounds are not drawn.")
    return tuple(sorted(moments, key=lambda moment: moment.time_s)), tuple(notes)


def _traces(folder: str | Path) -> tuple[Path, ...]:
    try:
        return traces_of(folder)
    except UsageError:
        return ()


def _missed_steps(trace: ProgramTrace, start_us: int) -> Iterator[Moment]:
    for number, record in enumerate(trace.file.records):
        if record.kind == "step":
            step = trace.typed(number)
            if step.missed and step.at >= start_us:
                text = f"bound missed, {step.late_us / 1000:.0f} ms late"
                yield Moment((step.at - start_us) / 1_000_000, "missed", text)
