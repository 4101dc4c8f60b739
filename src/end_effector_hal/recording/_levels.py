"""``switches.csv``, ``tool_changer.csv`` and ``parts.csv``: one row per change.

The levels of switches are 1 on, 0 off, empty without a valid reading; the state of the tool changer is the integer of
``ChangerState``; a part is its name in the description, empty: none.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import ChangerState, is_name

from ._files import RecordingLimits
from ._rows import Line, TableWriter, read_header, read_lines, read_rows

FIXED = ("time_s",)
ON = "_on"
"""Ending of a column name, after the name of the channel."""
CHANGER_COLUMNS = ("time_s", "tool_changer")
PART_COLUMNS = ("time_s", "part")
_LEVELS = {"0": False, "1": True, "": None}

Levels = tuple[bool | None, ...]
Timed = TypeVar("Timed", bound=tuple[Any, ...])
"""A row whose first value is its time, s."""


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


class ChangerRow(NamedTuple):
    """The state of the tool changer from ``time_s`` (seconds since start) until the next row."""

    time_s: float
    state: ChangerState


class ChangesWriter(TableWriter[tuple[float, Any]]):
    """Writes a row when its content has changed; a row begins with its time. Thread-safe.

    Args:
        read: reads a row of the file from a line.

    Raises:
        UsageError: the file cannot be written, or is another kind of file.
    """

    def __init__(
        self,
        path: str | Path,
        columns: Sequence[str],
        read: Callable[[Line], tuple[float, Any]],
        limits: RecordingLimits | None = None,
    ) -> None:
        super().__init__(path, columns, limits)
        self._last = self._resumed(read)

    def write(self, time_s: float, shown: Any) -> bool:
        """Write what holds from ``time_s`` on; return False when it equals the last row."""
        self._check_time(time_s)
        with self._lock:
            if self._last is not None and self._last[1] == shown:
                return False
            row = (max(round(time_s, 6), self._last[0] if self._last else 0.0), shown)
            self._file.append(self._text(row))
            self._last = row
        return True

    def _text(self, row: tuple[float, Any]) -> str:
        return f"{row[0]:.6f},{row[1]}\n"


class SwitchesWriter(ChangesWriter):
    """Writes the levels of switches."""

    def __init__(
        self, path: str | Path, channels: Sequence[str], limits: RecordingLimits | None = None
    ) -> None:
        self.channels = tuple(channels)
        columns = _columns(channels)
        super().__init__(path, (*FIXED, *columns), lambda line: _switches_row(line, columns, 0.0), limits)

    def write(self, time_s: float, shown: Mapping[str, bool | None]) -> bool:
        """Write the levels from ``time_s`` on (missing: unknown); return False when they equal the last row."""
        return super().write(time_s, tuple(shown.get(channel) for channel in self.channels))

    def _text(self, row: tuple[float, Levels]) -> str:
        return super()._text((row[0], ",".join("" if level is None else str(int(level)) for level in row[1])))


class ChangerWriter(ChangesWriter):
    """Writes the state of the tool changer."""

    def __init__(self, path: str | Path, limits: RecordingLimits | None = None) -> None:
        super().__init__(path, CHANGER_COLUMNS, _changer_row, limits)

    def _text(self, row: tuple[float, ChangerState]) -> str:
        return super()._text((row[0], int(row[1])))


class PartsWriter(ChangesWriter):
    """Writes the name (`is_part_name`) of the part that is gripped, held or released."""

    def __init__(self, path: str | Path, limits: RecordingLimits | None = None) -> None:
        super().__init__(path, PART_COLUMNS, _part_row, limits)


def is_part_name(name: str) -> bool:
    """Return whether a text from outside can be the name of a part; an empty one names none."""
    return not name or (is_name(name) and name.isidentifier())


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
    rows, _ = read_rows(
        lines, lambda line, earliest_s: _switches_row(line, columns, earliest_s), itemgetter(0)
    )
    return SwitchesLog(tuple(column.removesuffix(ON) for column in columns), tuple(rows), str(path))


def read_changer(path: str | Path) -> tuple[ChangerRow, ...]:
    """Return the states of the tool changer in a recording; empty: the recording has no table of them.

    Raises UsageError with ``file:line`` if it is another kind of file; a truncated last line is left out.
    """
    return _read_if_there(path, CHANGER_COLUMNS, "a tool changer", _changer_row)


def read_parts(path: str | Path) -> tuple[tuple[float, str], ...]:
    """Return the times and the names of the parts in a recording; empty: the recording has no table of them.

    Raises UsageError with ``file:line`` if it is another kind of file; a truncated last line is left out.
    """
    return _read_if_there(path, PART_COLUMNS, "parts", _part_row)


def _read_if_there(
    path: str | Path, columns: Sequence[str], of: str, read: Callable[[Line, float], Timed]
) -> tuple[Timed, ...]:
    """Return the rows of a table that not every recording has."""
    if not Path(path).exists():
        return ()
    lines = read_lines(path)
    if read_header(lines, path, columns):
        raise UsageError(f"This is not a table of {of}.", where=f"{path}:1")
    return tuple(read_rows(lines, read, itemgetter(0))[0])


def _columns(channels: Sequence[str]) -> tuple[str, ...]:
    return tuple(f"{channel}{ON}" for channel in channels)


def _switches_row(line: Line, columns: tuple[str, ...], earliest_s: float) -> tuple[float, Levels]:
    time, *cells = line.fields((*FIXED, *columns))
    for column, cell in zip(columns, cells, strict=True):
        if cell not in _LEVELS:
            raise line.fault(f"{column} is {cell[:40]!r}, expected is 1, 0 or nothing.")
    return line.seconds(time, earliest_s), tuple(_LEVELS[cell] for cell in cells)


def _part_row(line: Line, earliest_s: float = 0.0) -> tuple[float, str]:
    time, part = line.fields(PART_COLUMNS)
    if not is_part_name(part):
        raise line.fault(f"part is {part[:40]!r}, expected is a name or nothing.")
    return line.seconds(time, earliest_s), part


def _changer_row(line: Line, earliest_s: float = 0.0) -> ChangerRow:
    time, state = line.fields(CHANGER_COLUMNS)
    value = line.number_of(state, CHANGER_COLUMNS[1])
    if value not in set(ChangerState):
        raise line.fault(f"tool_changer is {state[:40]}, expected is 0 to {max(ChangerState):d}.")
    return ChangerRow(line.seconds(time, earliest_s), ChangerState(int(value)))
