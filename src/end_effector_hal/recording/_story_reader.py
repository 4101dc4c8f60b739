"""Derive the story of a recording from its events."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from end_effector_hal.control import EventKind
from end_effector_hal.vocabulary import Cause, EndEffectorState

from ._alarms import AlarmRow
from ._events import EventRow
from ._run import RunInfo
from ._states import StatesLog
from ._story import (
    FAILED,
    Attempt,
    AttemptOutcome,
    Grip,
    GripDecision,
    Loss,
    Moment,
    Release,
    ReleaseCause,
    Reset,
    Story,
)
from ._verdict import moments_of, verdict_of

_ENDS = {
    EventKind.CONFIRMED: AttemptOutcome.CONFIRMED,
    EventKind.TIMED_OUT: AttemptOutcome.TIMED_OUT,
    EventKind.CLOSED_ON_NOTHING: AttemptOutcome.EMPTY,
}
_DECISIONS = {
    **dict.fromkeys((Cause.TIMED_OUT, Cause.EMPTY, Cause.LOST, Cause.REFUSED), GripDecision.ABORTED),
    Cause.CANCELLED: GripDecision.CANCELLED,
}
"""The decision of a grip that did not reach GRIPPED, by cause; with any other cause, the program was stopped."""
_RELEASES = {GripDecision.ABORTED: ReleaseCause.ABORT, GripDecision.CANCELLED: ReleaseCause.CANCEL}


@dataclass
class _Gripping:
    """A grip that is still running."""

    start_s: float
    part: str
    attempts: list[Attempt] = field(default_factory=list)
    resets: list[Reset] = field(default_factory=list)

    def begin(self, event: EventRow, of: int | None) -> None:
        before = next((each for each in reversed(self.attempts) if each.actuator == event.actuator), None)
        if before is not None and before.outcome in FAILED and (before.end_s or 0.0) < event.time_s:
            self.resets.append(Reset(event.actuator, before.end_s or 0.0, event.time_s))
        pending = AttemptOutcome.PENDING
        self.attempts.append(Attempt(event.actuator, event.attempt, event.time_s, None, pending, of))

    def end(self, event: EventRow, outcome: AttemptOutcome) -> None:
        for index, attempt in reversed([*enumerate(self.attempts)]):
            if attempt.actuator == event.actuator:
                self.attempts[index] = replace(attempt, end_s=event.time_s, outcome=outcome)
                return

    def decided(self, at: float | None, decision: GripDecision, culprit: str = "") -> Grip:
        pending = [each for each in self.attempts if each.outcome is AttemptOutcome.PENDING]
        attempts = self.attempts
        if at is not None:
            off = AttemptOutcome.DEACTIVATED
            attempts = [replace(a, end_s=at, outcome=off) if a in pending else a for a in attempts]
        found = culprit if any(each.actuator == culprit for each in attempts) else None
        waiting = pending[-1].actuator if pending and found is None else None
        return Grip(
            self.start_s, at, decision, tuple(attempts), tuple(self.resets), found, waiting, self.part
        )


def _beginning(log: StatesLog) -> tuple[float, EndEffectorState]:
    """Return the time and the state in which the events begin.

    Old segments are removed of each table for itself, so rows of states from before the events belong to grips whose
    events are gone.
    """
    events = log.events or ()
    changes = (event for event in events if event.kind is EventKind.STATE_CHANGED)
    first = next(changes, None)
    if first is None:
        return (log.rows[0].time_s, log.rows[0].end_effector) if log.rows else (0.0, EndEffectorState.OFF)
    state, since = EndEffectorState(first.old), events[0].time_s
    for row in reversed([row for row in log.rows if row.time_s < events[0].time_s]):
        if row.end_effector != state:
            break
        since = row.time_s
    return since, state


class StoryFold:
    """Derives grips, releases and losses from events, which may begin and end in any state.

    Args:
        info: the maximum number of failed attempts of each actuator.
        part_at: returns the part of a grip that begins at a time, s; empty: it has no name.
    """

    def __init__(self, info: RunInfo, part_at: Callable[[float], str]) -> None:
        self._info, self._part_at = info, part_at
        self.grips: list[Grip] = []
        self.releases: list[Release] = []
        self.losses: list[Loss] = []
        self.adopted: EndEffectorState | None = None
        self._grip: _Gripping | None = None
        self._release: Release | None = None
        self._cause = ReleaseCause.DROP

    def finish(self) -> None:
        """End the story: a grip or a release that is still running stays unfinished."""
        if self._grip is not None:
            self.grips.append(self._grip.decided(None, GripDecision.UNFINISHED))
        if self._release is not None:
            self.releases.append(self._release)

    def take(self, event: EventRow) -> None:
        """Process the next event."""
        if event.kind is EventKind.STATE_CHANGED:
            self._change(event, EndEffectorState(event.old), EndEffectorState(event.new))
        elif event.kind is EventKind.ATTEMPT_BEGAN and self._grip is not None:
            self._grip.begin(event, self._info.attempts(event.actuator, self._grip.part))
        elif event.kind in _ENDS and self._grip is not None:
            self._grip.end(event, _ENDS[event.kind])
        elif event.kind is EventKind.DEACTIVATED:
            release = self._unwind(event.time_s)
            self._release = replace(release, deactivated=(*release.deactivated, event.actuator))
        elif event.command == "drop":
            self._finish(event.time_s, EndEffectorState.GRIP_ERROR)
            self._cause = ReleaseCause.DROP

    def begin(self, at: float, state: EndEffectorState) -> None:
        """Process the state in which the recording begins, or which a program adopted at its start."""
        if state is EndEffectorState.GRIPPING:
            self._grip = _Gripping(at, self._part_at(at))
        elif state in (EndEffectorState.GRIPPED, EndEffectorState.GRIP_ERROR):
            self.adopted = state

    def _change(self, event: EventRow, old: EndEffectorState, new: EndEffectorState) -> None:
        state, at = EndEffectorState, event.time_s
        if self._grip is not None and new is not state.GRIPPING:
            stopped = GripDecision.STOPPED
            gripped = new is state.GRIPPED
            decision = GripDecision.GRIPPED if gripped else _DECISIONS.get(event.cause, stopped)
            failed = event.cause in (Cause.TIMED_OUT, Cause.EMPTY) and not gripped
            self.grips.append(self._grip.decided(at, decision, event.actuator if failed else ""))
            self._grip, self._cause = None, _RELEASES.get(decision, self._cause)
        elif (old, new) == (state.GRIPPED, state.GRIP_ERROR):
            self.losses.append(Loss(at, event.actuator))
            self._cause = ReleaseCause.LOSS
        elif old is state.OFF or (new is state.GRIPPING and self._grip is None):
            self.begin(at, new)
        elif new is state.GRIPPING and self._grip is not None:  # its end is not recorded
            self.grips.append(self._grip.decided(at, GripDecision.STOPPED))
            self.begin(at, new)
        if event.cause is Cause.RELEASED_AT_START:
            self._cause = ReleaseCause.START
        if new is state.RELEASING:
            self._unwind(at)
        elif new is not state.GRIP_ERROR or old is state.RELEASING:
            self._finish(at, new)

    def _unwind(self, at: float) -> Release:
        self._release = self._release or Release(self._cause, at, None, (), None)
        return self._release

    def _finish(self, at: float, ended: EndEffectorState) -> None:
        if self._release is not None:
            self.releases.append(replace(self._release, end_s=at, ended=ended))
            self._release = None


def read_story(log: StatesLog, info: RunInfo | None = None, alarms: Sequence[AlarmRow] = ()) -> Story:
    """Return the story of a recording: the grips and releases that its events report.

    Args:
        log: the states, with their events; without events neither grips nor releases are known.
        info: the maximum number of failed attempts of each actuator, and the requirement that a counterexample
            violates.
        alarms: the alarms to list among the moments of the story.
    """
    info = info or RunInfo()
    fold = StoryFold(info, log.part_at)
    fold.begin(*_beginning(log))
    for event in log.events or ():
        fold.take(event)
    fold.finish()
    story = Story(
        log.actuators,
        tuple(fold.grips),
        tuple(fold.releases),
        tuple(fold.losses),
        fold.adopted,
        log.rows[-1].end_effector if log.rows else None,
        moments=(),
        verdict="",
    )
    moments = moments_of(log, story, alarms)
    if not info.violated:
        return replace(story, moments=moments, verdict=verdict_of(log, story))
    verdict = f"VIOLATED at {info.violated_s:g} s: {info.violated}"
    return replace(story, moments=_with_violation(moments, info.violated_s), verdict=verdict)


def _with_violation(moments: Sequence[Moment], at_s: float) -> tuple[Moment, ...]:
    """Return the moments of a counterexample, with a mark for the violation.

    No moment is shown as a success. Failures at the time of the violation or later share its mark.
    """
    kept, words = [], []
    for moment in moments:
        if moment.time_s >= at_s and moment.kind in ("abort", "lost", "timeout"):
            words.append(moment.text)
        else:
            kept.append(replace(moment, kind="command") if moment.kind == "gripped" else moment)
    kept.append(Moment(at_s, "lost", " – ".join((*words, "VIOLATED"))))
    return tuple(sorted(kept, key=lambda each: each.time_s))
