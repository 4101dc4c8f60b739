"""Evaluate an activation with a detector of other values, and derive the outcome of the grip."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from end_effector_hal.kinds import detector_of
from end_effector_hal.kinds.stanza import Actuator, Supply
from end_effector_hal.vocabulary import Evidence, to_us

from ._attempts import RecordedAttempt


@dataclass(frozen=True, slots=True)
class TriedCourse:
    """When an activation was confirmed, lost and gone.

    Times of ``confirmed`` and ``lost`` are µs after the activation, of ``gone`` µs after the deactivation.

    Attributes:
        confirmed: first confirmation during the activation; None: there was none.
        lost: first loss of the confirmation during the activation; None: there was none.
        gone: first proof, after the deactivation, that the actuator is gone; None: there was none.
    """

    confirmed: int | None = None
    lost: int | None = None
    gone: int | None = None


def course_of(actuator: Actuator, supply: Supply, activation: RecordedAttempt) -> TriedCourse:
    """Sample every reading of an activation with a new detector of ``part``."""
    detector = detector_of(actuator, supply)
    confirmed = lost = gone = None
    since, until = activation.since, activation.until
    for readings in activation.readings:
        at = readings.at
        level = detector.sample(readings, at)
        if until is not None and at >= until:
            if level is Evidence.GONE:
                gone = at - until
                break
        elif level is Evidence.CONFIRMED:
            confirmed = at - since if confirmed is None else confirmed
        elif confirmed is not None and lost is None and level in (Evidence.GONE, Evidence.PARTIAL):
            lost = at - since
    return TriedCourse(confirmed, lost, gone)


@dataclass(frozen=True, slots=True)
class GripOutcome:
    """The outcome that a grip would have had for one actuator.

    Attributes:
        failed: none of the recorded attempts would have been confirmed within the time-out.
        lost: the actuator was confirmed, and lost while it was still active.
        stuck: feedback was still present when the wait of the release was over.
        undecided: the recording ends during the attempt, or the release.
        attempt: number of the confirmed attempt, from 1; 0: no attempt was confirmed.
        after_us: time from the first activation to the confirmation, µs; None: no attempt was confirmed.
    """

    failed: bool = False
    lost: bool = False
    stuck: bool = False
    undecided: bool = False
    attempt: int = 0
    after_us: int | None = None


def outcome_of(
    actuator: Actuator, activations: Sequence[RecordedAttempt], courses: Sequence[TriedCourse]
) -> GripOutcome:
    """Return the outcome of the attempts of one grip with the time-outs of ``part``.

    Args:
        part: the actuator.
        activations: its recorded attempts.
        courses: the course of each attempt, with the thresholds of ``part``.
    """
    timeout_us = to_us(actuator.timeout_s)
    failed, lost, undecided, attempt = True, False, False, 0
    after_us: int | None = None
    for number, (each, course) in enumerate(zip(activations, courses, strict=True), start=1):
        if number > actuator.attempts:
            break
        if course.confirmed is not None and course.confirmed <= timeout_us:
            failed, attempt, lost = False, number, course.lost is not None
            after_us = each.since - activations[0].since + course.confirmed
            break
        ended = each.until if each.until is not None else each.seen_until
        if ended - each.since < timeout_us - SLACK_US:
            failed, undecided = False, True
            break
    stuck, unknown = _release(actuator, activations[-1], courses[-1])
    return GripOutcome(failed, lost, stuck, undecided or unknown, attempt, after_us)


SLACK_US = 100_000
"""Allowed deviation of a recorded time-out from the declared one, µs: two periods of a usual link."""


def _release(actuator: Actuator, last: RecordedAttempt, course: TriedCourse) -> tuple[bool, bool]:
    """Return whether the feedback is present for too long, and whether that is unknown."""
    if last.until is None:
        return False, False
    limit_us = to_us(actuator.release_s)
    if course.gone is not None:
        return course.gone > limit_us, False
    known = last.seen_until - last.until >= limit_us
    return known, not known
