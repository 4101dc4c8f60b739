"""A recording for figures: read from its folder, drawn in a style, written as one table of numbers (``run.csv``)."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Self

from end_effector_hal.errors import UsageError, os_errors
from end_effector_hal.recording import (
    BEGUN,
    AlarmRow,
    ChangerRow,
    Moment,
    PressuresLog,
    RunTables,
    StatesLog,
    SwitchesLog,
    read_run,
)
from end_effector_hal.verification.replay import ProgramTrace, load_trace, traces_of
from end_effector_hal.vocabulary import ChangerState

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STYLES = ("timeline", "paper")
SCRIPT = "plot_run.m"


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

    def write_table(self, folder: Path) -> list[Path]:
        """Write ``run.csv``, all data in one table, and ``plot_run.m``, which plots it in MATLAB or Octave.

        Raises:
            UsageError: the files cannot be written, or the recording holds no row.
        """
        table, script = write_run_table(folder / "run.csv", self), folder / SCRIPT
        with os_errors("Cannot be written", script):
            script.write_bytes(Path(__file__).with_name(SCRIPT).read_bytes())
        return [table, script]

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


@dataclass(frozen=True)
class _Columns:
    """Columns from one table with its rows; ``before``: the cell text until the first row."""

    names: tuple[str, ...]
    times_s: Sequence[float]
    rows: Sequence[Sequence[str]]
    before: str = "NaN"

    def at(self, time_s: float) -> Sequence[Sequence[str]]:
        """Return the rows of an instant; if there are none, the row that holds then."""
        first, end = bisect_left(self.times_s, time_s), bisect_right(self.times_s, time_s)
        if first < end:
            return self.rows[first:end]
        return [self.rows[end - 1] if end else (self.before,) * len(self.names)]


def write_run_table(path: Path, run: RunTables) -> Path:
    """Write one table of a recording, with a row for each instant at which any value changes.

    Columns: ``time_s``, the columns of ``states.csv``, ``tool_changer`` if the recording has it, ``alarms`` (number of
    active alarms), ``CHANNEL_on`` for each switch (1 on, 0 off), ``CHANNEL_gauge_kpa`` for each pressure and
    ``CHANNEL_mm`` (or another unit) for each quantity. Unchanged values are repeated; unknown ones are ``NaN``. States
    that were left in the instant of their entry get a row each.

    Raises:
        UsageError: the file cannot be written, or the recording contains no row.
    """
    log = run.log
    if not log.rows:
        raise UsageError("This recording holds no row, so there is nothing to write.", where=log.source)
    columns = [
        _states(log), *_changer(run.changer), _alarms(run.alarms), *_switches(run.switches),
        *_pressures(run.pressures),
    ]  # fmt: skip
    lines = [",".join(("time_s", *(name for each in columns for name in each.names)))]
    for time_s in sorted({time_s for each in columns for time_s in each.times_s}):
        lines += [f"{time_s:.6f},{cells}" for cells in _rows(columns, time_s)]
    with os_errors("Cannot be written", path):
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def _rows(columns: Sequence[_Columns], time_s: float) -> Iterator[str]:
    """Yield the rows of one instant, with the rows of each table in their order."""
    found = [each.at(time_s) for each in columns]
    for number in range(max(map(len, found))):
        yield ",".join(cell for rows in found for cell in rows[min(number, len(rows) - 1)])


def _states(log: StatesLog) -> _Columns:
    rows = [[str(int(state)) for state in row.states] for row in log.rows]
    return _Columns(log.columns[1:], log.times_s, rows)


def _changer(rows: Sequence[ChangerRow]) -> list[_Columns]:
    texts = [[str(int(row.state))] for row in rows]
    times = [row.time_s for row in rows]
    return [_Columns(("tool_changer",), times, texts, str(int(ChangerState.UNKNOWN)))] if rows else []


def _alarms(rows: Sequence[AlarmRow]) -> _Columns:
    standing: set[tuple[str, str]] = set()
    counts = []
    for row in rows:
        (standing.add if row.event == BEGUN else standing.discard)(row.key)
        counts.append([str(len(standing))])
    return _Columns(("alarms",), [row.time_s for row in rows], counts, "0")


def _switches(log: SwitchesLog | None) -> list[_Columns]:
    if log is None:
        return []
    rows = [["NaN" if level is None else str(int(level)) for level in levels] for _, levels in log.rows]
    return [_Columns(log.columns, log.times_s, rows)]


def _pressures(log: PressuresLog | None) -> list[_Columns]:
    if log is None:
        return []
    digits = [3 if channel in log.units else 2 for channel in log.channels]
    rows = [
        [
            "NaN" if value is None else f"{value:.{decimals}f}"
            for value, decimals in zip(values, digits, strict=True)
        ]
        for _, values in log.samples
    ]
    return [_Columns(log.columns, log.times_s, rows)]
