"""From a recording to its story, in one pass over the rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

from end_effector_hal.errors import UsageError
from end_effector_hal.kinds import recorded_kind
from end_effector_hal.recording._run import RunInfo
from end_effector_hal.recording.story._moments import moments_of
from end_effector_hal.recording.story._story import (
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
from end_effector_hal.recording.story._verdict import verdict_of
from end_effector_hal.recording.tables import BEGUN, AlarmRow, StatesLog, StatesRow
from end_effector_hal.vocabulary import INACTIVE, PENDING, Command, EndEffectorState, display_name

_FULL = 0.9
"""An attempt this much shorter than the actuator's other time-outs did not time out."""


_INSTANT_S = 0.05
"""A time-out this long before an abort is the reason of it; earlier, and a reset was running."""


_EMPTY_S = 0.5
"""The alarm that an actuator has gripped nothing begins at most so long before the end of its attempt."""
_Emptied = Mapping[str, Sequence[float]]
"""When each actuator was shown to have gripped nothing, s."""


def _failed_at(attempt: Attempt, at: float) -> bool:
    return attempt.outcome in FAILED and at - (attempt.end_s or 0.0) <= _INSTANT_S


@dataclass
class _Gripping:
    """A grip while it is read."""

    start_s: float
    commanded: bool = False
    cancelled: bool = False
    attempts: list[Attempt] = field(default_factory=list)
    resets: list[Reset] = field(default_factory=list)
    emptied: _Emptied = field(default_factory=dict)

    def begin(self, actuator: str, at: float) -> None:
        before = self.of(actuator)
        if before and before[-1].outcome in FAILED and before[-1].end_s is not None:
            self.resets.append(Reset(actuator, before[-1].end_s, at))
        self.attempts.append(Attempt(actuator, len(before) + 1, at, None, AttemptOutcome.PENDING))

    def of(self, actuator: str) -> list[Attempt]:
        return [attempt for attempt in self.attempts if attempt.actuator == actuator]

    def end(self, actuator: str, at: float, outcome: AttemptOutcome) -> None:
        for index, attempt in enumerate(self.attempts):
            if attempt.actuator == actuator and attempt.outcome is AttemptOutcome.PENDING:
                self.attempts[index] = replace(attempt, end_s=at, outcome=outcome)

    def failure(self, actuator: str, at: float) -> AttemptOutcome:
        """How an attempt that failed at a time did so."""
        shown = any(-_INSTANT_S <= at - since <= _EMPTY_S for since in self.emptied.get(actuator, ()))
        return AttemptOutcome.EMPTY if shown else AttemptOutcome.TIMED_OUT

    def culprit(self, at: float, allowed: Mapping[str, int]) -> Attempt | None:
        """The attempt whose failure was the abort; None: the abort had another reason, a loss.

        It was pending until then, or failed in that instant; it was as long as the time-outs before it, or has gripped
        nothing; and it was the last one that ``allowed`` grants, where that is known.
        """
        latest = {attempt.actuator: attempt for attempt in self.attempts}.values()
        ended = [a for a in latest if a.outcome is AttemptOutcome.PENDING or _failed_at(a, at)]
        suspect = max(ended, key=lambda attempt: attempt.start_s, default=None)
        if suspect is None or suspect.number < allowed.get(suspect.actuator, 1):
            return None
        if self.failure(suspect.actuator, at) is AttemptOutcome.EMPTY:
            return suspect
        others = [
            a.length_s
            for a in self.of(suspect.actuator)
            if a is not suspect and a.outcome is not AttemptOutcome.EMPTY
        ]
        length = (suspect.end_s if suspect.end_s is not None else at) - suspect.start_s
        return None if any(other is not None and length < _FULL * other for other in others) else suspect


@dataclass
class _Releasing:
    """An unwinding while it is read."""

    cause: ReleaseCause
    start_s: float
    groups: list[tuple[str, ...]] = field(default_factory=list)

    def done(self, end_s: float | None, ended: EndEffectorState | None) -> Release:
        return Release(self.cause, self.start_s, end_s, tuple(self.groups), ended)


class _Reader:
    """Goes through the rows once; see `read_story`."""

    def __init__(self, log: StatesLog, allowed: Mapping[str, int], emptied: _Emptied) -> None:
        self.names, self.allowed, self.emptied = log.actuators, allowed, emptied
        self.grips: list[Grip] = []
        self.releases: list[Release] = []
        self.lost: list[Loss] = []
        self.adopted: EndEffectorState | None = None
        self.grip: _Gripping | None = None
        self.release: _Releasing | None = None
        blank = (INACTIVE,) * len(self.names)
        before_start = StatesRow(0.0, EndEffectorState.OFF, Command.NONE, blank)
        for before, row in pairwise((before_start, *log.rows)):
            self.read(before, row)
        if self.grip is not None:
            self.decide(self.grip, None, GripDecision.UNFINISHED)
        if self.release is not None:
            self.releases.append(self.release.done(None, None))

    def read(self, before: StatesRow, row: StatesRow) -> None:
        was, now, at = before.end_effector, row.end_effector, row.time_s
        if now is EndEffectorState.GRIPPING and self.grip is None:
            self.finish(at, now)
            self.grip = _Gripping(at, emptied=self.emptied)
        if self.grip is not None:
            self.grip.commanded |= row.command is Command.GRIP
            self.grip.cancelled |= row.command is Command.CANCEL and before.command is not Command.CANCEL
        self.actuate(before, row)
        if was is not now:
            self.enter(was, now, before, row)
        self.deactivate(before, row)
        # an unwinding that leaves something active, as declared, ends in a latched error
        latched = now is EndEffectorState.GRIP_ERROR and row.command is Command.NONE is not before.command
        if now not in (EndEffectorState.RELEASING, EndEffectorState.GRIP_ERROR) or latched:
            self.finish(at, now)

    def actuate(self, before: StatesRow, row: StatesRow) -> None:
        """Attempts begin and end; the one that ends together with the grip is left to `decide`."""
        if self.grip is None:
            return
        for name, old, new in zip(self.names, before.actuators, row.actuators, strict=True):
            if new == old:
                continue
            if new == PENDING:
                self.grip.begin(name, row.time_s)
            elif new != INACTIVE:
                self.grip.end(name, row.time_s, AttemptOutcome.CONFIRMED)
            elif row.end_effector is EndEffectorState.GRIPPING:
                failed = self.grip.failure(name, row.time_s)
                self.grip.end(name, row.time_s, AttemptOutcome.DEACTIVATED if self.grip.cancelled else failed)

    def enter(self, was: EndEffectorState, now: EndEffectorState, before: StatesRow, row: StatesRow) -> None:
        state, at = EndEffectorState, row.time_s
        if self.grip is not None and now is not state.GRIPPING:
            self.leave(self.grip, row)
        elif was is state.GRIPPED and now is state.GRIP_ERROR:
            changes = zip(self.names, before.actuators, row.actuators, strict=True)
            self.lost.append(Loss(at, tuple(name for name, old, new in changes if new == PENDING != old)))
        elif was is state.OFF and now in (state.GRIPPED, state.GRIP_ERROR):
            self.adopted = now
        elif now is state.RELEASING and self.release is None:
            self.release = _Releasing(ReleaseCause.DROP, at)

    def leave(self, grip: _Gripping, row: StatesRow) -> None:
        """GRIPPING has ended."""
        now, at = row.end_effector, row.time_s
        error = now is EndEffectorState.GRIP_ERROR
        # with the ending `hold` a cancel ends in an error without a command, and a Drop unwinds it
        held = error and (grip.cancelled or (grip.commanded and row.command is Command.NONE))
        suspect = grip.culprit(at, self.allowed)
        if now is EndEffectorState.GRIPPED:
            self.decide(grip, at, GripDecision.GRIPPED)
        elif grip.cancelled or held:
            self.decide(grip, at, GripDecision.CANCELLED)
            self.release = None if held else _Releasing(ReleaseCause.CANCEL, at)
        elif error or (suspect is not None and suspect.number > 1):
            self.decide(grip, at, GripDecision.ABORTED)
            self.release = _Releasing(ReleaseCause.ABORT, at)
        else:
            self.decide(grip, at, GripDecision.STOPPED)
            self.release = _Releasing(ReleaseCause.STOP, at)

    def decide(self, grip: _Gripping, at: float | None, decision: GripDecision) -> None:
        aborted = decision is GripDecision.ABORTED
        suspect = grip.culprit(at, self.allowed) if aborted and at is not None else None
        waiting = [
            a for a in grip.attempts if a.outcome in (AttemptOutcome.PENDING, AttemptOutcome.DEACTIVATED)
        ]
        for attempt in waiting if at is not None else ():
            last = suspect is not None and suspect.actuator == attempt.actuator
            failed = grip.failure(attempt.actuator, at or 0.0)
            grip.end(attempt.actuator, at or 0.0, failed if last else AttemptOutcome.DEACTIVATED)
        self.grips.append(
            Grip(
                grip.start_s,
                at,
                decision,
                tuple(grip.attempts),
                tuple(grip.resets),
                culprit=suspect.actuator if suspect else None,
                waiting=waiting[-1].actuator if waiting and suspect is None else None,
            )
        )
        self.grip = None

    def deactivate(self, before: StatesRow, row: StatesRow) -> None:
        if self.release is None:
            return
        changes = zip(self.names, before.actuators, row.actuators, strict=True)
        group = tuple(name for name, old, new in changes if old != INACTIVE and new == INACTIVE)
        if group:
            self.release.groups.append(group)

    def finish(self, at: float, ended: EndEffectorState) -> None:
        if self.release is not None:
            self.releases.append(self.release.done(at, ended))
            self.release = None


def _emptied(log: StatesLog, info: RunInfo, alarms: Sequence[AlarmRow]) -> _Emptied:
    found: dict[str, list[float]] = {}
    for name in log.actuators if alarms else ():
        try:
            text = f"{display_name(name)} {recorded_kind(name, info.actuators).empty}."
        except UsageError:  # its kind is not installed here
            continue
        found[name] = [row.time_s for row in alarms if row.event == BEGUN and row.text == text]
    return found


def read_story(log: StatesLog, info: RunInfo | None = None, alarms: Sequence[AlarmRow] = ()) -> Story:
    """The story of a recording.

    ``alarms`` become moments of it, and say which attempts have gripped nothing. ``info`` adds only how many attempts
    an actuator may fail; without it that number is known once a grip was aborted. An attempt begins at PENDING and ends
    at ON or OFF; it failed when it went OFF while the end-effector was GRIPPING, or when its end was the abort (paper,
    section III.C).
    """
    known = {name: info.attempts(name) for name in log.actuators} if info else {}
    allowed = {name: number for name, number in known.items() if number is not None}
    reader = _Reader(log, allowed, _emptied(log, info or RunInfo(), alarms))
    grips = tuple(reader.grips)
    seen = {grip.culprit: grip.of(grip.culprit)[-1].number for grip in grips if grip.culprit is not None}
    limits = seen | allowed
    grips = tuple(
        replace(grip, attempts=tuple(replace(a, of=limits.get(a.actuator)) for a in grip.attempts))
        for grip in grips
    )
    story = Story(
        log.actuators,
        grips,
        tuple(reader.releases),
        tuple(reader.lost),
        reader.adopted,
        log.rows[-1].end_effector if log.rows else None,
        moments=(),
        verdict="",
    )
    moments = moments_of(log, story, alarms)
    if info is None or not info.violated:
        return replace(story, moments=moments, verdict=verdict_of(log, story))
    verdict = f"VIOLATED at {info.violated_s:g} s: {info.violated}"
    return replace(story, moments=_with_violation(moments, info.violated_s), verdict=verdict)


def _with_violation(moments: Sequence[Moment], at_s: float) -> tuple[Moment, ...]:
    """Nothing in a counterexample is a success; what goes wrong as it ends shares its mark."""
    told, words = [], []
    for moment in moments:
        if moment.time_s >= at_s and moment.kind in ("abort", "lost", "timeout"):
            words.append(moment.text)
        else:
            told.append(replace(moment, kind="command") if moment.kind == "gripped" else moment)
    told.append(Moment(at_s, "lost", " – ".join((*words, "VIOLATED"))))
    return tuple(sorted(told, key=lambda each: each.time_s))
