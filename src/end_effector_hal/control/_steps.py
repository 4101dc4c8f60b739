"""Attempts and times of each step of a grip, read off what the automata put out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import ClassVar

from end_effector_hal.vocabulary import EndEffectorState, to_s

from ._status import StepReport

_ON = 2


class StepLog:
    """Follows outputs and states; counts, decides nothing."""

    MEMORY: ClassVar = {
        "_outputs": tuple[bool, ...],
        "_begun": list[int | None],
        "_ee": int,
        "steps": tuple[StepReport, ...],
        "step": int,
    }

    def __init__(self, names: Sequence[str]) -> None:
        self._names = tuple(names)
        self._outputs = (False,) * len(self._names)
        self._begun: list[int | None] = [None] * len(self._names)
        self._ee = 0
        self.steps: tuple[StepReport, ...] = ()
        self.step = -1

    def take(
        self, ee: int, outputs: tuple[bool, ...], actuators: tuple[int, ...], at: int, *, again: bool = False
    ) -> None:
        """One more step of the automata, at a time in µs; ``again``: another attempt of what stays active."""
        gripping = ee == EndEffectorState.GRIPPING
        if gripping and self._ee != EndEffectorState.GRIPPING:
            self.steps = tuple(StepReport(name) for name in self._names)
            self._begun = [None] * len(self._names)
        if gripping or self._ee == EndEffectorState.GRIPPING:
            self.steps = tuple(
                self._next(report, index, outputs[index], actuators[index], at, again=again)
                for index, report in enumerate(self.steps)
            )
        if not gripping:
            self.step = -1
        self._ee, self._outputs = ee, outputs

    def _next(
        self, report: StepReport, index: int, active: bool, state: int, at: int, *, again: bool
    ) -> StepReport:
        if again and index == self.step:
            report = replace(report, attempts=report.attempts + 1)
        if active and not self._outputs[index]:
            self.step = index
            if self._begun[index] is None:
                self._begun[index] = at
            report = replace(report, attempts=report.attempts + 1)
        begun = self._begun[index]
        if begun is None or report.confirmed:
            return report
        return replace(report, seconds=to_s(at - begun), confirmed=active and state == _ON)
