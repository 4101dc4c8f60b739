"""How much is verified and how long that may take; all subjects, one after the other."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import log
from typing import Any

from ._subject import Subject, check


@dataclass(frozen=True)
class Plan:
    """Sizes, and seconds that each subject may take at most; what is not finished by then is left out.

    Attributes:
        fischer: numbers of processes.
        steps: numbers of actuators.
        together_s: for all requirements of the shipped tool, in one exploration.
        alone_s: for the same, one by one; 0: left out.
        fischer_s, steps_s: for each size.
        all_steps_s: for all numbers of actuators together.
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
    """What came out."""

    together: Subject
    alone: Subject | None
    fischer: tuple[Subject, ...]
    steps: tuple[Subject, ...]

    @property
    def growth(self) -> float | None:
        """The exponent e of time ~ steps^e, least squares over the sizes that were finished."""
        return exponent([(one.size, one.seconds) for one in self.steps if one.finished])

    @property
    def growth_of_states(self) -> float | None:
        """The same of the states, which no other load of the machine disturbs."""
        return exponent([(one.size, one.states) for one in self.steps if one.finished])

    def as_json(self) -> dict[str, Any]:
        """For the file."""
        return {
            "together": self.together.as_json(),
            "alone": self.alone and self.alone.as_json(),
            "fischer": [subject.as_json() for subject in self.fischer],
            "steps": [subject.as_json() for subject in self.steps],
            "growth_exponent": self.growth,
            "growth_exponent_of_states": self.growth_of_states,
        }


def measure_verification(plan: Plan, say: Callable[[str], None]) -> Measured:
    """Check everything of a plan; a size after one that was not finished is not begun."""
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
    """The slope of a straight line through the logarithms; None of fewer than two points."""
    if len(points) < 2:
        return None
    logs = [(log(x), log(y)) for x, y in points]
    mean_x, mean_y = (sum(values) / len(logs) for values in zip(*logs, strict=True))
    return sum((x - mean_x) * (y - mean_y) for x, y in logs) / sum((x - mean_x) ** 2 for x, _ in logs)
