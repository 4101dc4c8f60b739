"""How much is verified, and how long that may take."""

from __future__ import annotations

from dataclasses import dataclass


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


# 32 steps take minutes and gigabytes: `make nightly` proves them
FULL = Plan((5, 6, 7), (2, 4, 8, 16), together_s=30, alone_s=180, fischer_s=90, steps_s=150, all_steps_s=240)
QUICK = Plan((5,), (2, 4), together_s=30, alone_s=0, fischer_s=20, steps_s=15, all_steps_s=30)
