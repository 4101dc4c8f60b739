"""All subjects, one after the other."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import log
from typing import Any

from ._plan import Plan
from ._subject import Subject, check


@dataclass(frozen=True)
class Measured:
    """What came out."""

    requirements: Subject
    fischer: tuple[Subject, ...]
    steps: tuple[Subject, ...]

    @property
    def common(self) -> dict[int, tuple[float, int]]:
        """Number of steps -> seconds and states of the queries that were answered for every size that was begun."""
        begun = [subject for subject in self.steps if subject.answers]
        sets = [{answer.query for answer in subject.answers} for subject in begun]
        shared = set.intersection(*sets) if sets else set()
        return {
            subject.size: (
                sum(answer.seconds for answer in subject.answers if answer.query in shared),
                sum(answer.states for answer in subject.answers if answer.query in shared),
            )
            for subject in begun
        }

    @property
    def growth(self) -> float | None:
        """The exponent e of time ~ steps^e, least squares over the sizes of `common`."""
        return exponent([(size, seconds) for size, (seconds, _) in self.common.items()])

    @property
    def growth_of_states(self) -> float | None:
        """The same of the states, which no other load of the machine disturbs."""
        return exponent([(size, states) for size, (_, states) in self.common.items()])

    def as_json(self) -> dict[str, Any]:
        """For the file."""
        return {
            "requirements": self.requirements.as_json(),
            "fischer": [subject.as_json() for subject in self.fischer],
            "steps": [subject.as_json() for subject in self.steps],
            "common": self.common,
            "growth_exponent": self.growth,
            "growth_exponent_of_states": self.growth_of_states,
        }


def measure_verification(plan: Plan, say: Callable[[str], None]) -> Measured:
    """Check everything of a plan; a size after one in which nothing was answered is not begun."""
    say("requirements of the shipped tool")
    requirements = check("requirements", 0, plan.requirements_s)
    fischer, steps = [], []
    for count in plan.fischer:
        say(f"Fischer, {count} processes")
        fischer.append(check("fischer", count, plan.fischer_s))
    end = time.monotonic() + plan.all_steps_s
    for count in plan.steps:
        longest_s = min(plan.steps_s, end - time.monotonic())
        if longest_s < 1 or (steps and not steps[-1].answers):
            say(f"not begun: {count} steps and more")
            break
        say(f"the gripping network with {count} steps")
        steps.append(check("steps", count, longest_s))
    return Measured(requirements, tuple(fischer), tuple(steps))


def exponent(points: Sequence[tuple[float, float]]) -> float | None:
    """The slope of a straight line through the logarithms; None of fewer than two points."""
    if len(points) < 2:
        return None
    logs = [(log(x), log(y)) for x, y in points]
    mean_x, mean_y = (sum(values) / len(logs) for values in zip(*logs, strict=True))
    return sum((x - mean_x) * (y - mean_y) for x, y in logs) / sum((x - mean_x) ** 2 for x, _ in logs)
