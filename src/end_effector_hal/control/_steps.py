"""Attempts and times of each step of a grip, derived from the events of the automata."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from end_effector_hal.vocabulary import to_s

from ._events import EventKind, ToolEvent
from ._status import StepReport


class StepLog:
    """Counts the attempts of each step and measures their time; makes no decisions."""

    MEMORY: ClassVar = {
        "_begun": list[int | None],
        "_gripping": bool,
        "steps": tuple[StepReport, ...],
        "step": int,
    }

    def __init__(self, names: Sequence[str]) -> None:
        self._names = tuple(names)
        self._begun: list[int | None] = [None] * len(self._names)
        self._gripping = False
        self.steps: tuple[StepReport, ...] = ()
        self.step = -1

    def take(self, events: Sequence[ToolEvent], at: int, *, gripping: bool) -> None:
        """Process a step of the automata at ``at`` µs; ``gripping``: the state after it is GRIPPING."""
        if gripping and not self._gripping:
            self.steps = tuple(map(StepReport, self._names))
            self._begun = [None] * len(self._names)
        if gripping or self._gripping:
            reports, began = list(self.steps), dict[int, int]()
            confirmed = -1
            for event in events:
                if event.kind is EventKind.ATTEMPT_BEGAN:
                    self.step = event.actuator
                    began[self.step] = event.attempt
                    if self._begun[self.step] is None:
                        self._begun[self.step] = at
                elif event.kind is EventKind.CONFIRMED:
                    confirmed = event.actuator
            for index, begun in enumerate(self._begun):
                report = reports[index]
                if begun is not None and (index in began or not report.confirmed):
                    attempts, seconds = began.get(index, report.attempts), to_s(at - begun)
                    reports[index] = StepReport(report.name, attempts, seconds, index == confirmed)
            self.steps = tuple(reports)
        if not gripping:
            self.step = -1
        self._gripping = gripping
