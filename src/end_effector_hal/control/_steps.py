"""Attempts and times of each step of a grip, read off what the automata put out."""

from __future__ import annotations

from collections.abc import Sequence
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
            self.steps = tuple([StepReport(name) for name in self._names])
            self._begun = [None] * len(self._names)
        if gripping or self._ee == EndEffectorState.GRIPPING:
            for index, active in enumerate(outputs):
                started = active and not self._outputs[index]
                if started and self._begun[index] is None:
                    self._begun[index] = at
                if (begun := self._begun[index]) is not None:
                    on = active and actuators[index] == _ON
                    self._update(index, at - begun, started=started, again=again, on=on)
        if not gripping:
            self.step = -1
        self._ee, self._outputs = ee, outputs

    def _update(self, index: int, since_us: int, *, started: bool, again: bool, on: bool) -> None:
        """The report of an actuator that was first activated ``since_us`` ago in this grip."""
        report = self.steps[index]
        attempts = report.attempts + (again and index == self.step) + started
        if started:
            self.step = index
        seconds, confirmed = (report.seconds, True) if report.confirmed else (to_s(since_us), on)
        updated = StepReport(report.name, attempts, seconds, confirmed)
        self.steps = (*self.steps[:index], updated, *self.steps[index + 1 :])
