"""Count the recorded grips that would have ended differently, for each threshold and time-out, by its value."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from end_effector_hal.description import Description
from end_effector_hal.kinds.stanza import Actuator

from ._attempts import GripOutcome, RecordedAttempt, RecordedGrip, TriedCourse, course_of, outcome_of
from ._parameters import TunableKey, not_tried, parameters_of

NARROWINGS = 8
"""Number of bisection steps between the last value without an effect and the first with one."""
SAMPLE_US = 20_000
"""Sample period of the usual link, µs."""
Report = Callable[[float], None]


class Counts(NamedTuple):
    """Numbers of grips by outcome with one value; only grips in which the actuator was activated are counted.

    Attributes:
        failed: none of the recorded attempts would have been confirmed within the time-out.
        late: confirmed on a later attempt, or later than with the current value by more than the reaction bound.
        lost: confirmed, and lost within the same hold.
        stuck: feedback was still present when the wait of the release was over.
        undecided: the recording ends before the outcome is known.
    """

    failed: int = 0
    late: int = 0
    lost: int = 0
    stuck: int = 0
    undecided: int = 0

    def __str__(self) -> str:
        """Return text such as ``3 failed, 1 late``."""
        return ", ".join(f"{number} {word}" for word, number in self._asdict().items() if number) or "none"


@dataclass(frozen=True)
class Tried:
    """The results of one number of the description, for all tried values.

    Attributes:
        parameter: the number.
        grips: number of grips on which it was tried.
        values: values with their counts, in order of the values, including the current one.
        same_from, same_to: the tried range around the current value in which no count changes.
        ends_below, ends_above: whether the range ends there because a count changes; if not, no value beyond was
            tried.
    """

    parameter: TunableKey
    grips: int
    values: tuple[tuple[float, Counts], ...]
    same_from: float
    same_to: float
    ends_below: bool
    ends_above: bool

    @property
    def today(self) -> Counts:
        """Counts of the current value."""
        return dict(self.values)[self.parameter.today]

    @property
    def changes(self) -> bool:
        """Whether any tried value changes a count."""
        return self.ends_below or self.ends_above

    def as_json(self) -> dict[str, Any]:
        """Return the results as JSON, for programs."""
        return {
            "key": self.parameter.key,
            "part": self.parameter.part,
            "unit": self.parameter.unit,
            "today": self.parameter.today,
            "grips": self.grips,
            "same_from": self.same_from,
            "same_to": self.same_to,
            "ends_below": self.ends_below,
            "ends_above": self.ends_above,
            "values": [{"value": value, **counts._asdict()} for value, counts in self.values],
        }


@dataclass(frozen=True)
class Tuning:
    """The results of all thresholds and time-outs of a description on recorded grips.

    Attributes:
        description: the tool with the current values.
        grips: number of recorded grips.
        set_aside: number of grips, by actuator, that are not used because the readings do not explain the recorded
            decisions.
        tried: results in the order of a grip.
        not_tried: keys that no recorded grip can judge, with the reason.
    """

    description: Description
    grips: int
    set_aside: dict[str, int]
    tried: tuple[Tried, ...]
    not_tried: tuple[tuple[str, str], ...]

    def as_json(self) -> dict[str, Any]:
        """Return the results as JSON, for programs."""
        return {
            "description": self.description.name,
            "grips": self.grips,
            "set_aside": self.set_aside,
            "parameters": [each.as_json() for each in self.tried],
            "not_tried": [{"key": key, "why": why} for key, why in self.not_tried],
        }


def tune(
    grips: Sequence[RecordedGrip],
    description: Description,
    recorded: Sequence[Description] = (),
    report: Report = lambda _: None,
) -> Tuning:
    """Try values of every threshold and time-out on recorded grips.

    Grips of different parts are not mixed: each is judged by the values of its part. An attempt is judged from its own
    activation on, which the recorded tool decided. So each number is tried alone, on readings that are the response to
    the decisions of the recorded tool.

    Args:
        grips: grips of one tool, from a `GripCollector`.
        description: the tool with the current values.
        recorded: the tool of each recording: a grip is set aside if the recorded thresholds do not lead from the
            readings to the recorded decisions; default: ``description``.
        report: called with the finished share, 0 to 1.
    """
    found: dict[tuple[str, str], list[list[RecordedAttempt]]] = {}
    aside: dict[str, int] = {}
    names = description.part_names
    for grip in grips:
        part = grip.part or names[0]
        for name, attempts in grip.activations.items():
            tool = recorded[grip.recording] if recorded else description
            if part in names and _as_recorded(attempts, name, tool, grip.part):
                found.setdefault((part, name), []).append(attempts)
            else:
                aside[name] = aside.get(name, 0) + 1
    parameters, tried = [each for part in names for each in parameters_of(description, part)], list[Tried]()
    trials: dict[tuple[str, str], _Trial] = {}
    for number, parameter in enumerate(parameters):
        report(number / len(parameters))
        of = parameter.part, parameter.actuator
        if of not in trials:
            tool = description.for_part(parameter.part)
            trials[of] = _Trial(tool, parameter.actuator, found.get(of, []))
        if trials[of].grips:
            tried.append(trials[of].run(parameter))
    return Tuning(description, len(grips), aside, tuple(tried), tuple(not_tried(description)))


def _as_recorded(
    activations: Sequence[RecordedAttempt], name: str, recorded: Description, gripped: str
) -> bool:
    """Return whether the recorded thresholds lead from the readings to the recorded decisions."""
    if gripped and gripped not in recorded.part_names:
        return False
    actuator = recorded.for_part(gripped).actuators[name]
    slack_us = max(recorded.bounds.reaction_ms * 1000, 2 * SAMPLE_US)
    for each in activations:
        found = course_of(actuator, recorded.supply, each).confirmed
        if each.confirmed is None:
            # what is confirmed as the time-out passes may be decided either way
            if found is not None and each.since + found < (each.until or each.seen_until) - slack_us:
                return False
        elif found is None or abs(each.since + found - each.confirmed) > slack_us:
            return False
    return True


class _Trial:
    """The recorded attempts of one actuator, and their outcomes with other values."""

    def __init__(self, description: Description, name: str, grips: list[list[RecordedAttempt]]) -> None:
        self._description, self._part, self.grips = description, description.actuators[name], grips
        self._late_us = description.bounds.reaction_ms * 1000
        self._courses = self._follow(self._part)
        self._today = self._outcomes(self._part, self._courses)

    def run(self, parameter: TunableKey) -> Tried:
        """Try every value of the grid, then narrow the edges of the range in which nothing changes."""
        found: dict[float, Counts] = {}
        for value in parameter.grid():
            if (counts := self._counts(parameter, value)) is not None:
                found[value] = counts
        today = found.setdefault(parameter.today, self._count(self._today))
        edges = []
        for way in (-1, 1):
            values = sorted(found, reverse=way < 0)
            values = values[values.index(parameter.today) :]
            same, other = _edge(values, found, today)
            for _ in range(NARROWINGS if other is not None else 0):
                middle = float(f"{(same + (other or same)) / 2:.4g}")
                middle = float(round(middle)) if parameter.whole else middle
                counts = None if middle in (same, other) else self._counts(parameter, middle)
                if counts is None:
                    break
                found[middle] = counts
                same, other = (middle, other) if counts == today else (same, middle)
            edges.append((same, other is not None))
        (low, below), (high, above) = edges
        return Tried(parameter, len(self.grips), tuple(sorted(found.items())), low, high, below, above)

    def _counts(self, parameter: TunableKey, value: float) -> Counts | None:
        """Return the counts of a value; None: the value alone is invalid."""
        if value == parameter.today:
            return self._count(self._today)
        part = parameter.with_value(self._part, self._description.supply, value)
        if part is None:
            return None
        courses = self._courses if parameter.waits else self._follow(part)
        return self._count(self._outcomes(part, courses))

    def _follow(self, actuator: Actuator) -> list[list[TriedCourse]]:
        return [[course_of(actuator, self._description.supply, each) for each in grip] for grip in self.grips]

    def _outcomes(self, actuator: Actuator, courses: list[list[TriedCourse]]) -> list[GripOutcome]:
        return [outcome_of(actuator, grip, each) for grip, each in zip(self.grips, courses, strict=True)]

    def _count(self, outcomes: Sequence[GripOutcome]) -> Counts:
        pairs = list(zip(outcomes, self._today, strict=True))
        return Counts(
            failed=sum(each.failed for each in outcomes),
            late=sum(self._late(each, today) for each, today in pairs),
            lost=sum(each.lost for each in outcomes),
            stuck=sum(each.stuck for each in outcomes),
            undecided=sum(each.undecided for each in outcomes),
        )

    def _late(self, outcome: GripOutcome, today: GripOutcome) -> bool:
        if outcome.after_us is None:
            return False
        later = today.after_us is not None and outcome.after_us > today.after_us + self._late_us
        return outcome.attempt > 1 or later


def _edge(values: Sequence[float], found: dict[float, Counts], today: Counts) -> tuple[float, float | None]:
    """Return the last value without an effect, and the first with an effect; None: there is none."""
    same = values[0]
    for value in values[1:]:
        if found[value] != today:
            return same, value
        same = value
    return same, None
