"""``run.csv``: all tables of a recording in one, with numbers only."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from end_effector_hal.errors import UsageError, os_errors
from end_effector_hal.recording import (
    BEGUN,
    AlarmRow,
    ChangerRow,
    PressuresLog,
    RunTables,
    StatesLog,
    SwitchesLog,
)
from end_effector_hal.vocabulary import ChangerState


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
