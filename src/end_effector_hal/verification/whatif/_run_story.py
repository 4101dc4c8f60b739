"""The story of one run, from the records of its programs: states, alarms, and a line for everything that happened."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from end_effector_hal.control import Status, StatusLines, alarm_changes, refused
from end_effector_hal.description import Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.recording import (
    AlarmRow,
    ChangerRow,
    RunInfo,
    StatesLog,
    StatesRow,
    Story,
    read_story,
    run_info,
)
from end_effector_hal.verification.replay import Entry
from end_effector_hal.vocabulary import ChangerState, display_name

MOST_LINES = 20_000
"""So much is told of one run; what bounds a recording that was made to be endless."""


@dataclass(frozen=True, slots=True)
class StoryLine:
    """What happened: seconds since the recording began, and a sentence."""

    time_s: float
    text: str


class RunStory:
    """Takes the records of a run, and tells what happened in it.

    Args:
        description: the tool.
        begin: time zero, µs.

    Attributes:
        lines: in order of time; at most `MOST_LINES`.
        rows: the states, one for each change.
        alarms, changer: as in a recording's tables.
        left_out: how many lines were too many.
    """

    def __init__(self, description: Description, begin: int) -> None:
        self.description = description
        self.info: RunInfo = run_info(description)
        self.lines: list[StoryLine] = []
        self.rows: list[StatesRow] = []
        self.alarms: list[AlarmRow] = []
        self.changer: list[ChangerRow] = []
        self.left_out = 0
        self._begin = begin
        self._words = {program: StatusLines(description, program) for program in ("grip", "tool_change")}
        self._standing: dict[str, tuple[str, ...]] = {}
        self._asked: dict[str, str] = {}

    def take(self, entry: Entry) -> None:
        """One record of it."""
        at_s = max(0.0, (entry.at - self._begin) / 1e6)
        if entry.kind == "status":
            self._status(entry.program, entry.record, at_s)
        elif entry.kind == "command":
            self._asked[entry.program] = entry.record.name
        elif entry.kind == "answer" and not entry.record.accepted:
            self._add(at_s, refused(self._asked.get(entry.program, "a command"), entry.record.reason))

    @property
    def log(self) -> StatesLog:
        """Its states, as a figure takes them."""
        return StatesLog(self.description.sequence, tuple(self.rows))

    @cached_property
    def story(self) -> Story:
        """What it came to; ask for it when everything was taken."""
        return read_story(self.log, self.info, self.alarms)

    def _status(self, program: str, status: Status, at_s: float) -> None:
        for line in self._words[program].of(status):
            self._add(at_s, line)
        before = self._standing.get(program, ())
        if status.alarms != before:
            for text, over in alarm_changes(before, status.alarms):
                self._add(at_s, f"{'over' if over else 'alarm'}: {text}")
            self.alarms += [AlarmRow(at_s, "ended", text) for text in before if text not in status.alarms]
            self.alarms += [AlarmRow(at_s, "begun", text) for text in status.alarms if text not in before]
            self._standing[program] = status.alarms
        if program == "grip":
            row = StatesRow(at_s, status.ee, status.command, tuple(map(int, status.actuators)))
            if not self.rows or self.rows[-1].states != row.states:
                self._actuators(self.rows[-1] if self.rows else None, row)
                self.rows.append(row)
        elif self.description.tool_changer is not None and (
            not self.changer or self.changer[-1].state != status.changer
        ):
            self.changer.append(ChangerRow(at_s, ChangerState(status.changer)))

    def _actuators(self, before: StatesRow | None, now: StatesRow) -> None:
        for index, (name, part) in enumerate(self.description.ordered):
            states, state = kind_of(part).states, now.actuators[index]
            if before is not None and before.actuators[index] != state:
                self._add(now.time_s, f"{display_name(name)}: {states(state).label}")

    def _add(self, at_s: float, text: str) -> None:
        if len(self.lines) < MOST_LINES:
            self.lines.append(StoryLine(at_s, text))
        else:
            self.left_out += 1
