"""The tables of a recording that are compared."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from end_effector_hal.kinds import recorded_kind
from end_effector_hal.recording._run import RunInfo
from end_effector_hal.recording.tables import (
    BEGUN,
    AlarmRow,
    ChangerRow,
    PressuresLog,
    StatesLog,
    SwitchesLog,
)
from end_effector_hal.vocabulary import Command

Change = tuple[float, str]
"""Time of a change, s, and the new value."""


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
        """Time of the first command; without a command, the time of the first row."""
        rows = self.log.rows
        return next((row.time_s for row in rows if row.command is not Command.NONE), rows[0].time_s)

    def lines(self) -> Iterator[tuple[str, list[Change]]]:
        """Yield each line of the figure with its changes in words."""
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


def _changes(rows: list[Change]) -> list[Change]:
    return [row for row, before in zip(rows, [(0.0, ""), *rows], strict=False) if row[1] != before[1]]
