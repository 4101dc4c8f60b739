"""Counts of the grips, attempts and losses of a running tool, for monitoring systems."""

from __future__ import annotations

from collections import Counter
from itertools import product

from end_effector_hal.control import Status
from end_effector_hal.description import Description
from end_effector_hal.recording import AttemptOutcome, GripDecision, RunInfo, StoryFold, event_row

DECISIONS = tuple(each for each in GripDecision if each is not GripDecision.UNFINISHED)
OUTCOMES = tuple(each for each in AttemptOutcome if each is not AttemptOutcome.PENDING)


class GripCounts:
    """Counts what the events of a tool mean, from the first status on.

    A grip that began before the HAL was connected is not counted, because its attempts are not known.

    Attributes:
        grips: number of ended grips, by part (empty: it has no name) and outcome.
        first_attempts: number of grips that succeeded with each actuator confirmed on its first attempt, by part.
        attempts: number of ended attempts, by actuator and outcome.
        confirm_s: sum of the times from the activation to the confirmation, s, by actuator.
        losses: number of losses of a held part, by actuator (empty: unknown).
    """

    def __init__(self, description: Description) -> None:
        self._sequence, self._part = description.sequence, ""
        parts, names = description.part_names, description.sequence
        # from 0 on, so that the first of a kind is an increase
        self.grips = Counter(dict.fromkeys(product(parts, map(str, DECISIONS)), 0))
        self.attempts = Counter(dict.fromkeys(product(names, map(str, OUTCOMES)), 0))
        self.first_attempts, self.losses = Counter(dict.fromkeys(parts, 0)), Counter(dict.fromkeys(names, 0))
        self.confirm_s = dict.fromkeys(names, 0.0)
        self.restart()

    def restart(self) -> None:
        """Forget the running grip, because events are missing; the counts stay."""
        self._fold = StoryFold(RunInfo(), lambda _: self._part)
        self._has_begun = False

    def status(self, status: Status) -> None:
        """Process the events of a published status; those of the first one were before the connection."""
        self._part = status.part
        if self._has_begun:
            for event in status.events:
                self._fold.take(event_row(event, event.at / 1e6, self._sequence))
            self._count()
        self._has_begun = True

    def _count(self) -> None:
        for grip in self._fold.grips:
            self.grips[grip.part, str(grip.decision)] += 1
            self.first_attempts[grip.part] += grip.first_attempt
            for attempt in grip.attempts:
                self.attempts[attempt.actuator, str(attempt.outcome)] += 1
            for name, seconds in grip.confirm_s.items():
                self.confirm_s[name] += seconds
        for loss in self._fold.losses:
            self.losses[loss.actuator] += 1
        for done in (self._fold.grips, self._fold.losses, self._fold.releases):
            done.clear()
