"""How much is verified, and how long that may take."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Plan:
    """Sizes, and seconds that each subject may take at most; what is not finished by then is left out.

    Attributes:
        fischer: numbers of processes.
        steps: numbers of actuators.
        requirements_s: for all requirements of the shipped tool.
        fischer_s, steps_s: for each size.
        all_steps_s: for all numbers of actuators together.
    """

    fischer: tuple[int, ...]
    steps: tuple[int, ...]
    requirements_s: float
    fischer_s: float
    steps_s: float
    all_steps_s: float


FULL = Plan((5, 6, 7), (2, 4, 8, 16, 32, 64), requirements_s=90, fischer_s=30, steps_s=30, all_steps_s=100)
QUICK = Plan((5,), (2, 4), requirements_s=15, fischer_s=10, steps_s=5, all_steps_s=10)
