"""The tables of a recording that are compared."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from end_effector_hal.errors import UsageError
from end_effector_hal.kinds import recorded_kind
from end_effector_hal.recording._run import RunInfo, read_run
from end_effector_hal.recording.tables import (
    BEGUN,
    AlarmRow,
    ChangerRow,
    PressuresLog,
    StatesLog,
    SwitchesLog,
    read_alarms,
    read_changer,
    read_pressures,
    read_states,
    read_switches,
)
from end_effector_hal.vocabulary import Command

Change = tuple[float, str]
"""When a line has changed, s, and what it is from then on."""


@dataclass(frozen=True)
class RunTables:
    """Tables of one recording; times in seconds since its start."""

    log: StatesLog
    info: RunInfo
    pressures: PressuresLog | None = None
    changer: tuple[ChangerRow, ...] = ()
    alarms: tuple[AlarmRow, ...] = ()
    switches: SwitchesLog | None = None

    @property
    def first_command_s(self) -> float:
        """When the first command is executed; without one the first row."""
        rows = self.log.rows
        return next((row.time_s for row in rows if row.command is not Command.NONE), rows[0].time_s)

    def lines(self) -> Iterator[tuple[str, list[Change]]]:
        """Each line of the figure, and its changes in words."""
        rows = self.log.rows
        yield "end_effector", _changes([(row.time_s, row.end_effector.label) for row in rows])
        yield "command", _changes([(row.time_s, row.command.label) for row in rows])
        for index, name in enumerate(self.log.actuators):
            words = recorded_kind(name, self.info.actuators).states
            yield name, _changes([(row.time_s, words(row.actuators[index]).label) for row in rows])
        yield "tool_changer", _changes([(row.time_s, row.state.label) for row in self.changer])
        # an alarm may come again: each is a change
        yield (
            "alarms",
            [
                (row.time_s, f"{'' if row.event == BEGUN else f'{row.event}: '}{row.text}")
                for row in self.alarms
            ],
        )


def read_tables(folder: Path) -> RunTables:
    """Those of a folder that `eehal run --record`, `eehal demo` or DataLogger wrote.

    Raises:
        UsageError: there is none, it holds no row, or a table cannot be read.
    """
    states = folder / "states.csv" if folder.is_dir() else folder
    if not states.exists():
        raise UsageError(
            "This folder contains no recording.",
            where=str(folder),
            todo="Name a folder that `eehal run --record`, `eehal demo` or the launch file's log_directory wrote.",
        )
    log = read_states(states)
    if not log.rows:
        raise UsageError("This recording holds no row.", where=str(states))
    pressures = states.with_name("pressures.csv")
    return RunTables(
        log,
        read_run(states.parent),
        read_pressures(pressures) if pressures.exists() else None,
        read_changer(states.with_name("tool_changer.csv")),
        read_alarms(states.with_name("alarms.csv")),
        read_switches(states.with_name("switches.csv")),
    )


def _changes(rows: list[Change]) -> list[Change]:
    return [row for row, before in zip(rows, [(0.0, ""), *rows], strict=False) if row[1] != before[1]]
