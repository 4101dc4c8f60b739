"""The plan of the verification benchmark, and its measurement: all subjects, one after the other."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import log
from typing import Any

from ._subject import Subject, check


@dataclass(frozen=True)
class Plan:
    """Sizes, and the time limit of each subject in seconds; queries that are not finished by then are omitted.

    Attributes:
        fischer: numbers of processes.
        steps: numbers of actuators.
        together_s: limit for all requirements of the shipped tool, in one exploration.
        alone_s: limit for the same requirements one by one; 0: omitted.
        fischer_s, steps_s: limit for each size.
        all_steps_s: limit for all numbers of actuators together.
    """

    fischer: tuple[int, ...]
    steps: tuple[int, ...]
    together_s: float
    alone_s: float
    fischer_s: float
    steps_s: float
    all_steps_s: float


# 32 steps take minutes: `make nightly` proves them
FULL = Plan(
    (5, 6, 7, 8, 10), (2, 4, 8, 16), together_s=30, alone_s=180, fischer_s=90, steps_s=150, all_steps_s=240
)
QUICK = Plan((5,), (2, 4), together_s=30, alone_s=0, fischer_s=20, steps_s=15, all_steps_s=30)


@dataclass(frozen=True)
class Measured:
    """The results of the measurement."""

    together: Subject
    alone: Subject | None
    fischer: tuple[Subject, ...]
    steps: tuple[Subject, ...]

    @property
    def growth(self) -> float | None:
        """The exponent e of time ~ steps^e, least squares over the finished sizes."""
        return exponent([(one.size, one.seconds) for one in self.steps if one.finished])

    @property
    def growth_of_states(self) -> float | None:
        """The exponent of the number of states, which other load does not affect."""
        return exponent([(one.size, one.states) for one in self.steps if one.finished])

    def as_json(self) -> dict[str, Any]:
        """Return the JSON for the results file."""
        return {
            "together": self.together.as_json(),
            "alone": self.alone and self.alone.as_json(),
            "fischer": [subject.as_json() for subject in self.fischer],
            "steps": [subject.as_json() for subject in self.steps],
            "growth_exponent": self.growth,
            "growth_exponent_of_states": self.growth_of_states,
        }


def measure_verification(plan: Plan, say: Callable[[str], None]) -> Measured:
    """Check all subjects of a plan; after an unfinished size, larger sizes are not started."""
    say("requirements of the shipped tool, together")
    together = check("together", 0, plan.together_s)
    alone = None
    if plan.alone_s:
        say("requirements of the shipped tool, one by one")
        alone = check("alone", 0, plan.alone_s)
    fischer, steps = [], []
    for count in plan.fischer:
        say(f"Fischer, {count} processes")
        fischer.append(check("fischer", count, plan.fischer_s))
    end = time.monotonic() + plan.all_steps_s
    for count in plan.steps:
        longest_s = min(plan.steps_s, end - time.monotonic())
        if longest_s < 1 or (steps and not steps[-1].finished):
            say(f"not begun: {count} steps and more")
            break
        say(f"the gripping network with {count} steps")
        steps.append(check("steps", count, longest_s))
    return Measured(together, alone, tuple(fischer), tuple(steps))


def exponent(points: Sequence[tuple[float, float]]) -> float | None:
    """Return the slope of a straight line through the logarithms; None for fewer than two points."""
    if len(points) < 2:
        return None
    logs = [(log(x), log(y)) for x, y in points]
    mean_x, mean_y = (sum(values) / len(logs) for values in zip(*logs, strict=True))
    return sum((x - mean_x) * (y - mean_y) for x, y in logs) / sum((x - mean_x) ** 2 for x, _ in logs)
