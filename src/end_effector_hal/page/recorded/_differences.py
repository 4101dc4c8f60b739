"""Two recordings of a page: the tables that are compared, and their differences as `eehal compare` reports them."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from end_effector_hal.control import Status, ToolEvent
from end_effector_hal.description import Description, measures_of
from end_effector_hal.errors import ReportedError
from end_effector_hal.page.view import FRESH_US, Curve
from end_effector_hal.recording import (
    KPA,
    AlarmRow,
    ChangerRow,
    EventRow,
    PressuresLog,
    RunDifference,
    RunInfo,
    RunTables,
    StatesLog,
    StatesRow,
    Tolerances,
    changed_alarms,
    compare_runs,
    count_differences,
    event_row,
    pressure_channels,
)
from end_effector_hal.vocabulary import Alarm, display_name, printable

from ._samples import Samples

DECIMALS = 2
SCALE = 100.0
"""Scale in the channel's unit; a move of a hundredth of it between two samples is kept as a spike."""


@dataclass(frozen=True, slots=True)
class ComparedRecording:
    """One of two recordings that are compared.

    Attributes:
        name: name of the recording.
        tables: its tables, in seconds since its beginning; they may be empty.
        since_s, until_s: bounds of the part that is shown.
        step_s: time between two pressure samples.
        whole: whether the whole recording could be read.
    """

    name: str
    tables: RunTables
    since_s: float
    until_s: float
    step_s: float
    whole: bool


class TablesBuilder:
    """Builds the tables of a recording, record by record.

    Args:
        info: the facts about the run.
        epoch: time zero, µs.
        since: time from which pressures are kept, µs.
        step_us: time between two pressure samples, µs.

    Attributes:
        reasons: reasons of the tool, each with the time from which it was given, s.
    """

    def __init__(self, description: Description, info: RunInfo, epoch: int, since: int, step_us: int) -> None:
        self._info, self._epoch, self._since = info, epoch, since
        self._fitted = description.tool_changer is not None
        self._names, self._channels = description.sequence, pressure_channels(description)
        measures = measures_of(description)
        self._units = {name: measures[name].unit for name in self._channels if measures[name].unit != KPA}
        curves = [Curve(name, name, name, KPA, decimals=DECIMALS, most=SCALE) for name in self._channels]
        self._samples = Samples(curves, epoch, step_us)
        self._values: dict[str, tuple[int, Any]] = {}
        self._standing: tuple[Alarm, ...] = ()
        self._alarms: list[AlarmRow] = []
        self._changer: list[ChangerRow] = []
        self._rows: list[StatesRow] = []
        self._parts: list[tuple[float, str]] = []
        self._events: list[EventRow] = []
        self.reasons: list[tuple[float, str]] = []

    def status(self, status: Status, events: Sequence[ToolEvent]) -> None:
        """Add a status of the tool, and the events that came with it."""
        at_s = self._seconds(status.at)
        self._alarms += changed_alarms(at_s, self._standing, status.alarms)
        self._standing = status.alarms
        if self._fitted and (not self._changer or self._changer[-1].state != status.changer):
            self._changer.append(ChangerRow(at_s, status.changer))
        row = StatesRow(at_s, status.ee, status.command, status.actuators)
        if not self._rows or self._rows[-1].states != row.states:
            self._rows.append(row)
        for found, text in ((self._parts, status.part), (self.reasons, status.reason)):
            if (found[-1][1] if found else None) != text and (text or found is self._parts):
                found.append((at_s, text))
        self._events += (event_row(each, self._seconds(each.at), self._names) for each in events)

    def _seconds(self, at: int) -> float:
        return (at - self._epoch) / 1e6

    def frame(self, at: int, values: Mapping[str, Any]) -> None:
        """Add one frame of the sensors."""
        self._values |= {name: (at, values[name]) for name in self._channels if name in values}
        if at < self._since or not self._values:
            return
        row: list[Any] = [at]
        for name in self._channels:
            came_at, value = self._values.get(name, (at, None))
            row.append(None if value is None or at - came_at > FRESH_US else value / 1000)
        self._samples.take(row)

    def tables(self, source: str, *, has_events: bool) -> RunTables:
        """Return all tables; call it after the last record."""
        self._samples.flush()
        times, *columns = self._samples.columns
        recorded = {
            name: column
            for name, column in zip(self._channels, columns, strict=True)
            if any(value is not None for value in column)
        }
        rows = zip(times, zip(*recorded.values(), strict=True), strict=True) if recorded else ()
        samples = tuple((at_ms / 1000, values) for at_ms, values in rows)
        pressures = PressuresLog(tuple(recorded), samples, units=self._units)
        events = tuple(sorted(self._events, key=lambda row: row.time_s)) if has_events else None
        states = StatesLog(self._names, tuple(self._rows), source, "", events, tuple(self._parts))
        return RunTables(states, self._info, pressures, tuple(self._changer), tuple(self._alarms))


MOST_DIFFERENCES = 200
"""Largest number of differences that are listed."""
LONGEST = 300
"""Largest number of characters of one text."""


def compare_recordings(first: ComparedRecording, second: ComparedRecording) -> dict[str, Any]:
    """Return the differences as JSON, ``{said, rows, more}``; no content of a recording makes this fail.

    ``said`` is the number of differences, or the reason why nothing is compared. ``rows`` are the first
    `MOST_DIFFERENCES`: ``first_s`` and ``second_s`` (seconds since the beginning of each recording; None: absent from
    that recording), ``lane`` and ``what`` in words, and ``shift_s``: the time by which the second recording is shifted
    to align this moment in both (None: the difference has no time). ``more`` is a sentence about the differences that
    are not listed, or empty.
    """
    for each in (first, second):
        if not each.tables.log.rows:
            return _refused(f"{each.name} holds no state that can be read.")
    usual = Tolerances()
    # a value within a step may be drawn a step from where it was, in each of the two
    within = Tolerances(max(usual.seconds, 2 * max(first.step_s, second.step_s)), usual.kpa)
    try:
        found = compare_runs(first.tables, second.tables, within)
    except ReportedError as error:
        return _refused(str(error))
    start_s = first.tables.first_command_s - second.tables.first_command_s
    found = [each for each in found if _is_shown(each, first, second)]
    places = _Places(found, start_s)
    listed, more = found[:MOST_DIFFERENCES], len(found) - MOST_DIFFERENCES
    return {
        "said": _said(found, within, [each.name for each in (first, second) if not each.whole]),
        "rows": [_row(each, places.shift_s(each)) for each in listed],
        "more": f"And {count_differences(more).replace(' ', ' more ')}." if more > 0 else "",
    }


class _Places:
    """Computes how far the second recording is shifted against the first at each difference.

    A difference that is in only one recording uses the shift of the last difference before it that is in both.
    """

    def __init__(self, found: Sequence[RunDifference], start_s: float) -> None:
        self._start_s = start_s
        both = [
            (each.first_s, each.second_s)
            for each in found
            if each.first_s is not None and each.second_s is not None
        ]
        self._sides = [sorted((pair[side], pair[0] - pair[1]) for pair in both) for side in (0, 1)]

    def shift_s(self, each: RunDifference) -> float | None:
        if each.first_s is not None and each.second_s is not None:
            return each.first_s - each.second_s
        own_s = each.second_s if each.first_s is None else each.first_s
        if own_s is None:
            return None
        side = self._sides[each.first_s is None]
        index = bisect_right(side, own_s, key=lambda place: place[0])
        return side[index - 1][1] if index else self._start_s


def _is_shown(each: RunDifference, first: ComparedRecording, second: ComparedRecording) -> bool:
    """Return whether a difference has no time, or a time in the part of a recording that the page shows."""
    times = [(at, run) for at, run in ((each.first_s, first), (each.second_s, second)) if at is not None]
    return not times or any(run.since_s <= at <= run.until_s for at, run in times)


def _row(each: RunDifference, shift_s: float | None) -> dict[str, Any]:
    return {
        "first_s": _rounded(each.first_s),
        "second_s": _rounded(each.second_s),
        "lane": printable(display_name(each.line)),
        "what": printable(each.text, LONGEST),
        "shift_s": _rounded(shift_s),
    }


def _rounded(seconds: float | None) -> float | None:
    return None if seconds is None else round(seconds, 6)


def _said(found: Sequence[RunDifference], within: Tolerances, parts: Sequence[str]) -> str:
    count = count_differences(len(found)).capitalize()
    same = f"what is within {within.seconds:g} s and {within.kpa:g} kPa (gauge) of the other one is the same"
    said = f"{count}: both are counted from their first command, and {same}."
    if parts:
        said += f" Not all of {' and '.join(dict.fromkeys(parts))} could be read: what is missing there differs, too."
    return printable(said, LONGEST * 2)


def _refused(why: str) -> dict[str, Any]:
    return {"said": printable(f"The recordings cannot be compared. {why}"), "rows": [], "more": ""}
