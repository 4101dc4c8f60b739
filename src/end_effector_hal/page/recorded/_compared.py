"""The data of a recording that are compared with another: tables made of the same records as its document."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from end_effector_hal.control import Status
from end_effector_hal.description import Description, measures_of
from end_effector_hal.page.view import FRESH_US, Curve
from end_effector_hal.recording import (
    KPA,
    AlarmRow,
    ChangerRow,
    PressuresLog,
    RunInfo,
    RunTables,
    StatesLog,
    changed_alarms,
    pressure_channels,
)
from end_effector_hal.vocabulary import Alarm

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
    """Builds the tables of alarms, the tool changer and pressures, record by record; the states come from `Summary`.

    Args:
        description: the tool.
        epoch: time zero, µs.
        since: time from which pressures are kept, µs.
        step_us: time between two pressure samples, µs.
    """

    def __init__(self, description: Description, epoch: int, since: int, step_us: int) -> None:
        self._epoch, self._since = epoch, since
        self._fitted = description.tool_changer is not None
        self._channels = pressure_channels(description)
        measures = measures_of(description)
        self._units = {name: measures[name].unit for name in self._channels if measures[name].unit != KPA}
        curves = [Curve(name, name, name, KPA, decimals=DECIMALS, most=SCALE) for name in self._channels]
        self._samples = Samples(curves, epoch, step_us)
        self._values: dict[str, tuple[int, Any]] = {}
        self._standing: tuple[Alarm, ...] = ()
        self._alarms: list[AlarmRow] = []
        self._changer: list[ChangerRow] = []

    def status(self, status: Status) -> None:
        """Add a status of the tool."""
        at_s = (status.at - self._epoch) / 1e6
        self._alarms += changed_alarms(at_s, self._standing, status.alarms)
        self._standing = status.alarms
        if self._fitted and (not self._changer or self._changer[-1].state != status.changer):
            self._changer.append(ChangerRow(at_s, status.changer))

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

    def tables(self, states: StatesLog, info: RunInfo) -> RunTables:
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
        return RunTables(states, info, pressures, tuple(self._changer), tuple(self._alarms))
