"""``events.csv``: the events of a run, such as the start of an attempt or a time-out, one per row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from end_effector_hal.control import COMMANDS, EventKind, ToolEvent
from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import Cause, ChangerState, EndEffectorState

from ._files import RecordingLimits, numbered_files
from ._rows import Line, TableWriter, read_header, read_lines

Value = TypeVar("Value")
COLUMNS = ("time_s", "event", "actuator", "attempt", "old", "new", "cause", "command")
_KINDS = {str(each): each for each in EventKind}
_ATTEMPTS = {"": 0} | {str(number): number for number in range(1, 21)}
_COMMANDS = {name: name for name in ("", *COMMANDS)}
_CAUSES = {"" if each is Cause.NONE else each.name: each for each in Cause}
_OF_AN_ATTEMPT = (
    EventKind.ATTEMPT_BEGAN,
    EventKind.CONFIRMED,
    EventKind.TIMED_OUT,
    EventKind.CLOSED_ON_NOTHING,
)
_STATES = {EventKind.STATE_CHANGED: EndEffectorState, EventKind.CHANGER_CHANGED: ChangerState}


@dataclass(frozen=True, slots=True)
class EventRow:
    """One event, with its time in seconds since the start of the recording.

    Attributes:
        actuator: name of the actuator; empty: the event does not concern a single actuator.
        attempt, old, new, cause, command: as in `ToolEvent`.
    """

    time_s: float
    kind: EventKind
    actuator: str = ""
    attempt: int = 0
    old: int = -1
    new: int = -1
    cause: Cause = Cause.NONE
    command: str = ""

    def __post_init__(self) -> None:
        states = set(_STATES[self.kind]) if self.kind in _STATES else {-1}
        if not {self.old, self.new} <= states or self.attempt not in _ATTEMPTS.values():
            raise ValueError(
                f"{self.kind!r} with the states {self.old} and {self.new}, attempt {self.attempt}"
            )
        if self.command not in _COMMANDS:
            raise ValueError(f"{self.command[:40]!r} is no command")


def event_row(event: ToolEvent, time_s: float, actuators: Sequence[str]) -> EventRow:
    """Return the row of an event; raises ValueError for an impossible event.

    Args:
        event: the event.
        time_s: time of the event, seconds since the start of the recording.
        actuators: names of the actuators, in sequence order.
    """
    name = actuators[event.actuator] if event.actuator >= 0 else ""
    attempt, old, new = event.attempt, event.old, event.new
    return EventRow(max(0.0, time_s), event.kind, name, attempt, old, new, event.cause, event.command)


class EventsWriter(TableWriter[EventRow]):
    """Writes rows in the order of their arrival; thread-safe.

    Raises:
        UsageError: the file cannot be written, or is another kind of file.
    """

    def __init__(
        self, path: str | Path, actuators: Sequence[str], limits: RecordingLimits | None = None
    ) -> None:
        super().__init__(path, COLUMNS, limits)
        last = self._resumed(lambda line: _row(line, actuators, 0.0))
        self._earliest_s = last.time_s if last else 0.0

    def write(self, rows: Sequence[EventRow]) -> bool:
        """Write all rows or none; a time before that of the last row is replaced by it.

        Raises:
            ReportedError: the rows cannot be written.
        """
        if not rows:
            return False
        with self._lock:
            self._file.append("".join(map(self._text, rows)))
            self._earliest_s = max(self._earliest_s, *(round(row.time_s, 6) for row in rows))
        return True

    def _text(self, row: EventRow) -> str:
        states = [_STATES[row.kind](each).name if each >= 0 else "" for each in (row.old, row.new)]
        cause = row.cause.name if row.cause else ""
        cells = (row.kind, row.actuator, str(row.attempt or ""), *states, cause, row.command)
        return f"{max(self._earliest_s, round(row.time_s, 6)):.6f},{','.join(cells)}\n"


def read_events(path: str | Path, actuators: Sequence[str]) -> tuple[EventRow, ...] | None:
    """Return the events of a recording, in order; None: the recording has no table of events.

    Raises UsageError with ``file:line`` for an invalid row; a truncated last line is left out.

    Args:
        path: path of the table.
        actuators: the names of actuators that are valid in the table.
    """
    if not (Path(path).is_symlink() or Path(path).exists() or numbered_files(path)):
        return None
    lines = read_lines(path)
    if read_header(lines, path, COLUMNS):
        raise UsageError("This is not a table of events.", where=f"{path}:1")
    rows: list[EventRow] = []
    for line in lines:
        if not line.complete:
            break
        rows.append(_row(line, actuators, rows[-1].time_s if rows else 0.0))
    return tuple(rows)


def _row(line: Line, actuators: Sequence[str], earliest_s: float) -> EventRow:
    time, event, actuator, attempt, old, new, cause, command = line.fields(COLUMNS)
    kind = _chosen(line, "event", event, _KINDS)
    states = {each.name: int(each) for each in _STATES[kind]} if kind in _STATES else {"": -1}
    attempts = {
        text: number for text, number in _ATTEMPTS.items() if number or kind is not EventKind.ATTEMPT_BEGAN
    }
    some = () if kind in _OF_AN_ATTEMPT else ("",)
    return EventRow(
        line.seconds(time, earliest_s),
        kind,
        _chosen(line, "actuator", actuator, {name: name for name in (*some, *actuators)}),
        _chosen(line, "attempt", attempt, attempts),
        _chosen(line, "old", old, states),
        _chosen(line, "new", new, states),
        _chosen(line, "cause", cause, _CAUSES),
        _chosen(line, "command", command, _COMMANDS),
    )


def _chosen(line: Line, column: str, text: str, values: Mapping[str, Value]) -> Value:
    if text not in values:
        known = ", ".join(name or "nothing" for name in values)
        raise line.fault(f"{column} is {text[:40]!r}.", f"Expected is one of: {known}.")
    return values[text]
