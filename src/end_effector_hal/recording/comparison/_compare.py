"""Compare two recordings.

Rule 1: the zero of both is their first command, so that one recording may begin earlier than the other; a change
before it is never reported as a difference in time.

Rule 2: the changes of a line are aligned by their text, not by their time; numbers within an alarm are ignored.

Rule 3: a change that is in both is a difference if it is earlier or later than the changes before it suggest: an
additional time-out in one run is reported once, not again for every later change.

Rule 4: a pressure differs where neither value is near a value of the other run within the time tolerance.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from math import inf

from end_effector_hal.errors import UsageError
from end_effector_hal.recording.comparison._pressures import Shifts, pressure_differences
from end_effector_hal.recording.comparison._run_difference import RunDifference
from end_effector_hal.recording.comparison._run_tables import Change, RunTables
from end_effector_hal.vocabulary import display_name

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
