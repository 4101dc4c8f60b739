"""Find the moments of a story that a figure marks."""

from __future__ import annotations

from collections.abc import Sequence

from end_effector_hal.recording.story._story import (
    AttemptOutcome,
    Grip,
    GripDecision,
    Moment,
    Story,
)
from end_effector_hal.recording.tables import BEGUN, AlarmRow, StatesLog
from end_effector_hal.vocabulary import LATCHED_ERRORS, EndEffectorState, display_name

_TOGETHER_S = 0.2


def moments_of(log: StatesLog, story: Story, alarms: Sequence[AlarmRow] = ()) -> tuple[Moment, ...]:
    """Return the moments that a figure marks, in order of time.

    They are commands, time-outs, aborts, GRIPPED, losses, alarms and failed releases.
    """
    found = [
        Moment(each.time_s, "command", each.command.upper()) for each in log.events or () if each.command
    ]
    for grip in story.grips:
        found += _of_grip(grip)
    found += [
        Moment(loss.time_s, "lost", ": ".join(filter(None, ("grip lost", loss.who)))) for loss in story.losses
    ]
    found += _warnings(alarms)
    for release in story.releases:
        if release.ended is EndEffectorState.RELEASE_ERROR and release.end_s is not None:
            found.append(Moment(release.end_s, "lost", "release error"))
    return tuple(sorted(found, key=lambda moment: moment.time_s))


def _warnings(alarms: Sequence[AlarmRow]) -> list[Moment]:
    """Return a moment for each alarm that began; equal alarms of several actuators share one.

    Latched errors are left out because the states already show them.
    """
    found: dict[str, Moment] = {}
    moments = []
    for row in alarms:
        last = found.get(row.title)
        if row.event != BEGUN or row.id in LATCHED_ERRORS:
            continue
        if last is None or row.time_s - last.time_s > _TOGETHER_S:
            found[row.title] = Moment(row.time_s, "alarm", row.title)
            moments.append(found[row.title])
    return moments


def _of_grip(grip: Grip) -> list[Moment]:
    found = []
    for attempt in grip.failed:
        name = display_name(attempt.actuator)
        of = f"/{attempt.of}" if attempt.of else ""
        last = attempt.actuator == grip.culprit and attempt is grip.of(attempt.actuator)[-1]
        what = "time-out" if attempt.outcome is AttemptOutcome.TIMED_OUT else "empty"
        text = f"{name} {what} {attempt.number}{of}{' – abort' if last else ''}"
        found.append(Moment(attempt.end_s or 0.0, "abort" if last else "timeout", text))
    if grip.decided_s is not None:
        if grip.decision is GripDecision.GRIPPED:
            found.append(Moment(grip.decided_s, "gripped", "GRIPPED"))
        elif grip.decision is GripDecision.ABORTED and grip.culprit is None:
            found.append(Moment(grip.decided_s, "abort", "abort"))
    return found
