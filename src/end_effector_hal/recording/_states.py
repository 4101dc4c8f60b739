"""``states.csv``: one row per change of a state, with the integers of Table II."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from pathlib import Path

from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import ActuatorState, Command, EndEffectorState

from ._events import EventRow, read_events
from ._files import RecordingLimits, RunFile
from ._levels import read_parts
from ._rows import Line, TableWriter, read_header, read_lines

FIXED = ("time_s", "end_effector", "command")
TOGETHER_S = 0.1
"""Longest time between an event and the row of the same instant in another table, s."""


@dataclass(frozen=True, slots=True)
class StatesRow:
    """The states that are valid from ``time_s`` (seconds since the start) until the next row."""

    time_s: float
    end_effector: EndEffectorState
    command: Command
    actuators: tuple[int, ...]

    @property
    def states(self) -> tuple[int, ...]:
        """All columns except the time."""
        return (self.end_effector, self.command, *self.actuators)


@dataclass(frozen=True)
class StatesLog:
    """The states and events of a recording: actuator names in sequence order, rows in order of time.

    Attributes:
        note: a sentence about dropped content.
        events: the events of ``events.csv``; None: there is no such table.
        part_rows: the rows of ``parts.csv``: from when on which part is gripped, held or released, empty: none.
    """

    actuators: tuple[str, ...]
    rows: tuple[StatesRow, ...]
    source: str = ""
    note: str = ""
    events: tuple[EventRow, ...] | None = None
    part_rows: tuple[tuple[float, str], ...] = ()

    @property
    def columns(self) -> tuple[str, ...]:
        """The column names of the table."""
        return (*FIXED, *self.actuators)

    @property
    def times_s(self) -> tuple[float, ...]:
        """The time of each row, seconds since start."""
        return tuple(row.time_s for row in self.rows)

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of the parts in the recording, each once."""
        return tuple(dict.fromkeys(name for _, name in self.part_rows if name))

    def part_at(self, time_s: float) -> str:
        """Return the part of a grip that begins at this time; empty: it has no name."""
        rows, at = self.part_rows, itemgetter(0)
        first = bisect_left(rows, time_s - TOGETHER_S, key=at)
        last = bisect_right(rows, time_s + TOGETHER_S, key=at)
        return next((name for _, name in rows[first:last] if name), "")


class StatesWriter(TableWriter[StatesRow]):
    """Writes a row whenever a state has changed; thread-safe.

    Args:
        path: path of the file; it is continued if it has the same header, and refused (UsageError) if not.
        actuators: names of the actuators, in sequence order.
        limits: the limits of the folder; None: no limit.
    """

    def __init__(
        self, path: str | Path, actuators: Sequence[str], limits: RecordingLimits | None = None
    ) -> None:
        self._actuators = tuple(actuators)
        self._lacking = False
        super().__init__(path, (*FIXED, *self._actuators), limits)
        # the row after it must differ from it and not be earlier
        self._last = self._resumed(lambda line: _row(line, self._actuators, 0.0))

    @property
    def last(self) -> StatesRow | None:
        """The last row, also if an earlier process wrote it; a new row never has an earlier time."""
        return self._last

    def write(
        self, time_s: float, end_effector: int, command: int, actuators: Sequence[int] | Mapping[str, int]
    ) -> bool:
        """Write the states that are valid from ``time_s`` on (seconds since the start); return False when nothing
        changed.

        A time before that of the last row is replaced by it: rows are in the order of arrival. After a row that could
        not be written, the next one is written even if it equals the last written row, because the state changed in
        between.

        Raises:
            UsageError: a value is not in Table II.
            ReportedError: the row cannot be written.
        """
        values = (
            [actuators[name] for name in self._actuators]
            if isinstance(actuators, Mapping)
            else list(actuators)
        )
        if len(values) != len(self._actuators):
            raise UsageError(
                f"{len(values)} values for {len(self._actuators)} actuators.", where=str(self._file.path)
            )
        self._check_time(time_s)
        try:
            states = (EndEffectorState(end_effector), Command(command))
            row = tuple(int(ActuatorState(value)) for value in values)
        except ValueError as error:
            raise UsageError(f"Not in Table II: {error}.", where=str(self._file.path)) from None
        with self._lock:
            if not self._lacking and self._last is not None and self._last.states == (*states, *row):
                return False
            time_s = max(round(time_s, 6), self._last.time_s if self._last else 0.0)
            new = StatesRow(time_s, *states, row)
            self._lacking = True
            self._file.append(self._text(new))
            self._last, self._lacking = new, False
        return True

    def _text(self, row: StatesRow) -> str:
        return ",".join((f"{row.time_s:.6f}", *(str(int(value)) for value in row.states))) + "\n"


def read_states(path: str | Path) -> StatesLog:
    """Read a table of states, its ``events.csv`` and its ``parts.csv``.

    Raises UsageError with ``file:line`` for an invalid row. A truncated last line of the states is dropped and reported
    in ``note``; all earlier lines are kept.
    """
    lines = read_lines(path)
    actuators = read_header(lines, path, FIXED)
    rows: list[StatesRow] = []
    note = ""
    for line in lines:
        try:
            row = _row(line, actuators, rows[-1].time_s if rows else 0.0)
            if not rows or row != rows[-1]:  # a segment begins with the last row of the one before it
                rows.append(row)
        except UsageError:
            if line.complete:
                raise
            note = line.cut_off
    events = read_events(Path(path).with_name(RunFile.EVENTS), actuators)
    return StatesLog(
        actuators, tuple(rows), str(path), note, events, read_parts(Path(path).with_name(RunFile.PARTS))
    )


def _row(line: Line, actuators: tuple[str, ...], earliest_s: float) -> StatesRow:
    time, end_effector, command, *values = line.fields((*FIXED, *actuators))
    return StatesRow(
        line.seconds(time, earliest_s),
        EndEffectorState(_state(line, end_effector, "end_effector", EndEffectorState)),
        Command(_state(line, command, "command", Command)),
        tuple(_state(line, text, name, ActuatorState) for text, name in zip(values, actuators, strict=True)),
    )


def _state(
    line: Line, text: str, column: str, table: type[EndEffectorState | Command | ActuatorState]
) -> int:
    digits = text.removeprefix("-")
    if not (digits.isascii() and digits.isdigit() and len(digits) < 10):
        raise line.fault(f"{column} is {text[:40]!r}, expected is an integer of Table II.")
    if int(text) not in set(table):
        known = f"{min(table):d} to {max(table):d}"
        raise line.fault(f"{column} is {int(text)}, which Table II does not have.", f"Expected is {known}.")
    return int(text)
