"""``tool_changer.csv``: the state of the tool changer, as the integers of ``ChangerState``; one row per change."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from end_effector_hal.errors import UsageError
from end_effector_hal.recording._limits import RecordingLimits
from end_effector_hal.recording.tables._rows import Line, TableWriter, read_header, read_lines
from end_effector_hal.vocabulary import ChangerState

COLUMNS = ("time_s", "tool_changer")


@dataclass(frozen=True, slots=True)
class ChangerRow:
    """The state of the tool changer from ``time_s`` (seconds since start) until the next row."""

    time_s: float
    state: ChangerState


class ChangerWriter(TableWriter):
    """Writes a row when the state has changed; thread-safe.

    Raises:
        UsageError: the file cannot be written, or is another kind of file.
    """

    def __init__(self, path: str | Path, limits: RecordingLimits | None = None) -> None:
        super().__init__(path, COLUMNS, limits)
        self._last = self._resumed(lambda line: _row(line, 0.0))

    def write(self, time_s: float, state: ChangerState) -> bool:
        """Write the state that holds from ``time_s`` on; return False when it equals the last row."""
        self._check_time(time_s)
        with self._lock:
            if self._last is not None and self._last.state is state:
                return False
            row = ChangerRow(max(round(time_s, 6), self._last.time_s if self._last else 0.0), state)
            self._file.append(_text(row))
            self._last = row
        return True

    def _opening(self) -> str:
        return _text(self._last) if self._last is not None else ""


def read_changer(path: str | Path) -> tuple[ChangerRow, ...]:
    """Return the states of the tool changer in a recording; empty: the recording has no table of them.

    Raises UsageError with ``file:line`` if it is another kind of file; a truncated last line is left out.
    """
    if not Path(path).exists():
        return ()
    lines = read_lines(path)
    if read_header(lines, path, COLUMNS):
        raise UsageError("This is not a table of a tool changer.", where=f"{path}:1")
    rows: list[ChangerRow] = []
    for line in lines:
        if not line.complete:
            break
        row = _row(line, rows[-1].time_s if rows else 0.0)
        if not rows or row != rows[-1]:  # a segment begins with the last row of the one before it
            rows.append(row)
    return tuple(rows)


def _text(row: ChangerRow) -> str:
    return f"{row.time_s:.6f},{int(row.state)}\n"


def _row(line: Line, earliest_s: float) -> ChangerRow:
    time, state = line.fields(COLUMNS)
    value = line.number_of(state, COLUMNS[1])
    if value not in set(ChangerState):
        raise line.fault(f"tool_changer is {state[:40]}, expected is 0 to {max(ChangerState):d}.")
    return ChangerRow(line.seconds(time, earliest_s), ChangerState(int(value)))
