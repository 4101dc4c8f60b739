"""Compare the tables of two recordings."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from math import inf
from pathlib import Path
from typing import Self

from end_effector_hal.errors import UsageError
from end_effector_hal.kinds import recorded_kind
from end_effector_hal.vocabulary import Command, display_name

from ._alarms import BEGUN, AlarmRow, read_alarms
from ._compared_pressures import RunDifference, Shifts, pressure_differences
from ._files import RunFile
from ._levels import ChangerRow, SwitchesLog, read_changer, read_switches
from ._pressures import PressuresLog, read_pressures
from ._run import RunInfo, read_run
from ._states import StatesLog, read_states

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

    @classmethod
    def read(cls, states: Path, faults: list[str] | None = None) -> Self:
        """Read ``states.csv`` and the files beside it; raises UsageError if one cannot be read.

        ``faults``: receives the error of damaged pressures, which are then left out.
        """
        log, info, beside = read_states(states), read_run(states.parent), states.with_name
        pressures: PressuresLog | None = None
        try:
            if beside(RunFile.PRESSURES).exists():
                pressures = read_pressures(beside(RunFile.PRESSURES))
        except UsageError as error:
            if faults is None:
                raise
            faults.append(str(error))
        changer, alarms = read_changer(beside(RunFile.CHANGER)), read_alarms(beside(RunFile.ALARMS))
        return cls(log, info, pressures, changer, alarms, read_switches(beside(RunFile.SWITCHES)))

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


MOST_CHANGES = 2_000
"""Maximum number of changes of one line; the time of the alignment grows with its square."""
_NUMBERS = re.compile(r"\d+(?:\.\d+)?")


@dataclass(frozen=True)
class Tolerances:
    """The largest deviations that do not count as a difference: ``seconds`` in time, ``kpa`` in a pressure."""

    seconds: float = 0.1
    kpa: float = 5.0


@dataclass(frozen=True)
class _Pair:
    """A change that both recordings have on one line."""

    line: str
    text: str
    first_s: float
    second_s: float

    @property
    def shift_s(self) -> float:
        return self.second_s - self.first_s


def compare_runs(
    first: RunTables, second: RunTables, tolerances: Tolerances | None = None
) -> list[RunDifference]:
    """Return the differences, in order of time.

    Raises:
        UsageError: a line of a recording has too many changes to be aligned.
    """
    tolerances = tolerances or Tolerances()
    start_s = second.first_command_s - first.first_command_s
    lines, others = dict(first.lines()), dict(second.lines())
    found: list[RunDifference] = []
    pairs: list[_Pair] = []
    for line in dict.fromkeys([*lines, *others]):
        if line not in lines or line not in others:
            which = "first" if line in lines else "second"
            found.append(RunDifference(line, f"only the {which} recording has it", None, None))
            continue
        for source, changes in ((first, lines[line]), (second, others[line])):
            if len(changes) > MOST_CHANGES:
                raise UsageError(
                    f"{display_name(line)} has {len(changes)} changes; {MOST_CHANGES} can be compared.",
                    where=source.log.source,
                )
        matched, alone = _aligned(line, lines[line], others[line])
        pairs += matched
        found += alone
    shifts = Shifts(start_s)
    commanded = (pair for pair in pairs if pair.first_s >= first.first_command_s)
    for pair in sorted(commanded, key=lambda each: each.first_s):
        moved_s = pair.shift_s - shifts.latest_s
        if abs(moved_s) > tolerances.seconds:
            found.append(RunDifference(pair.line, _moved(pair.text, moved_s), pair.first_s, pair.second_s))
            shifts.add(pair.first_s, pair.shift_s)
    found += pressure_differences(
        first.pressures, second.pressures, shifts, tolerances.seconds, tolerances.kpa
    )
    return sorted(found, key=lambda each: _at(each, start_s))


def _at(difference: RunDifference, start_s: float) -> float:
    """Return the time on the clock of the first recording; differences without a time come first."""
    if difference.first_s is not None:
        return difference.first_s
    return -inf if difference.second_s is None else difference.second_s - start_s


def _moved(text: str, by_s: float) -> str:
    return f"{text}: {abs(by_s):.2f} s {'later' if by_s > 0 else 'earlier'} in the second"


def _aligned(
    line: str, first: Sequence[Change], second: Sequence[Change]
) -> tuple[list[_Pair], list[RunDifference]]:
    keys, others = ([_NUMBERS.sub("#", text) for _, text in each] for each in (first, second))
    # what began alike is the same: a longest common part alone would pair a first attempt with a second one
    alike = next(
        (i for i, (a, b) in enumerate(zip(keys, others, strict=False)) if a != b), min(len(keys), len(others))
    )
    pairs = [_Pair(line, *each) for each in _both(first[:alike], second[:alike])]
    alone: list[RunDifference] = []
    matcher = SequenceMatcher(None, keys[alike:], others[alike:], autojunk=False)
    for tag, a0, a1, b0, b1 in matcher.get_opcodes():
        ours, theirs = first[alike + a0 : alike + a1], second[alike + b0 : alike + b1]
        if tag == "equal":
            pairs += (_Pair(line, *each) for each in _both(ours, theirs))
            continue
        alone += (RunDifference(line, f"{text}: only in the first", at, None) for at, text in ours)
        alone += (RunDifference(line, f"{text}: only in the second", None, at) for at, text in theirs)
    return pairs, alone


def _both(first: Sequence[Change], second: Sequence[Change]) -> Iterator[tuple[str, float, float]]:
    return ((text, at, other) for (at, text), (other, _) in zip(first, second, strict=True))
