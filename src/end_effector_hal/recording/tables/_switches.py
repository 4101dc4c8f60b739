"""``switches.csv``: the levels of switches, 1 on, 0 off, empty without a valid reading; one row per change."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from end_effector_hal.errors import UsageError
from end_effector_hal.recording._limits import RecordingLimits
from end_effector_hal.recording.tables._rows import Line, TableWriter, read_header, read_lines

FIXED = ("time_s",)
ON = "_on"
"""Ending of a column name, after the name of the channel."""
_LEVELS = {"0": False, "1": True, "": None}

Levels = tuple[bool | None, ...]


@dataclass(frozen=True)
class SwitchesLog:
    """Rows in order of time: seconds since the start, and the levels from then on; None: unknown."""

    channels: tuple[str, ...]
    rows: tuple[tuple[float, Levels], ...]
    source: str = ""

    @property
    def times_s(self) -> tuple[float, ...]:
        """The time of each row, seconds since start."""
        return tuple(time_s for time_s, _ in self.rows)

    def levels(self, channel: str) -> tuple[bool | None, ...]:
        """Return the levels of one channel, one for each row."""
        index = self.channels.index(channel)
        return tuple(levels[index] for _, levels in self.rows)


class SwitchesWriter(TableWriter):
    """Writes a row when a level has changed; thread-safe.

    Raises:
        UsageError: the file cannot be written, or is another kind of file.
    """

    def __init__(
        self, path: str | Path, channels: Sequence[str], limits: RecordingLimits | None = None
    ) -> None:
        self.channels = tuple(channels)
        columns = tuple(f"{channel}{ON}" for channel in channels)
        super().__init__(path, (*FIXED, *columns), limits)
        self._last = self._resumed(lambda line: _row(line, columns, 0.0))

    def write(self, time_s: float, levels: Mapping[str, bool | None]) -> bool:
        """Write the levels from ``time_s`` on (missing: unknown); return False when they equal the last row."""
        self._check_time(time_s)
        row = tuple(levels.get(channel) for channel in self.channels)
        with self._lock:
            if self._last is not None and self._last[1] == row:
                return False
            new = (max(round(time_s, 6), self._last[0] if self._last else 0.0), row)
            self._file.append(_text(new))
            self._last = new
        return True

    def _opening(self) -> str:
        return _text(self._last) if self._last is not None else ""


def read_switches(path: str | Path) -> SwitchesLog | None:
    """Return the switches of a recording; None: the recording has no table of switches.

    Raises UsageError with ``file:line`` if it is another kind of file; a truncated last line is left out.
    """
    if not Path(path).exists():
        return None
    lines = read_lines(path)
    columns = read_header(lines, path, FIXED)
    if not columns or not all(column.endswith(ON) and column != ON for column in columns):
        raise UsageError("This is not a table of switches.", where=f"{path}:1")
    rows: list[tuple[float, Levels]] = []
    for line in lines:
        if not line.complete:
            break
        row = _row(line, columns, rows[-1][0] if rows else 0.0)
        if not rows or row != rows[-1]:  # a segment begins with the last row of the one before it
            rows.append(row)
    return SwitchesLog(tuple(column.removesuffix(ON) for column in columns), tuple(rows), str(path))


def _text(row: tuple[float, Levels]) -> str:
    return ",".join((f"{row[0]:.6f}", *("" if level is None else str(int(level)) for level in row[1]))) + "\n"


def _row(line: Line, columns: tuple[str, ...], earliest_s: float) -> tuple[float, Levels]:
    time, *cells = line.fields((*FIXED, *columns))
    for column, cell in zip(columns, cells, strict=True):
        if cell not in _LEVELS:
            raise line.fault(f"{column} is {cell[:40]!r}, expected is 1, 0 or nothing.")
    return line.seconds(time, earliest_s), tuple(_LEVELS[cell] for cell in cells)
