"""Summarize a story: in one sentence, and as the moments that a figure marks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import groupby

from end_effector_hal.vocabulary import LATCHED_ERRORS, EndEffectorState, display_name

from ._alarms import BEGUN, AlarmRow
from ._events import EventRow
from ._states import StatesLog
from ._story import AttemptOutcome, Grip, GripDecision, Moment, Release, ReleaseCause, Story

_HELD = {GripDecision.ABORTED: ReleaseCause.ABORT, GripDecision.CANCELLED: ReleaseCause.CANCEL}
"""The release that normally follows each decision; without it, outputs stay active, as declared."""
_LATCHED = (EndEffectorState.GRIP_ERROR, EndEffectorState.RELEASE_ERROR)


def verdict_of(log: StatesLog, story: Story) -> str:
    """Return text such as ``Cylinder never confirmed: grip ABORTED after 3 attempts, released in reverse order``."""
    if story.final is None:
        return "Nothing was recorded"
    if log.events is None:
        return f"No events were recorded, so grips are not known, ends in {story.final.label}"
    if not story.grips:
        return _without_grip(log, story)
    if len(story.grips) > 1:
        return _of_many(story)
    grip = story.grips[0]
    parts = [_of_grip(grip, story), *_aftermath(log, story)]
    return ", ".join(part for part in parts if part)


def _without_grip(log: StatesLog, story: Story) -> str:
    assert story.final is not None
    if story.adopted is not None:
        return ", ".join([f"Adopted as {story.adopted.label}", *_aftermath(log, story)])
    commands = [
        command for command, _ in groupby(each.command.upper() for each in log.events or () if each.command)
    ]
    done = f"{', '.join(commands)}: no grip" if commands else "No grip"
    return f"{done}, {'ends' if len(log.rows) > 1 else 'stays'} in {story.final.label}"


def _of_many(story: Story) -> str:
    count = Counter(f"{grip.decision} {grip.part}".rstrip() for grip in story.grips)
    culprits = ((grip.culprit, grip) for grip in story.grips if grip.culprit is not None)
    reasons = [f"{display_name(name)} {_failed(grip)}" for name, grip in culprits]
    why = f" ({'; '.join(dict.fromkeys(reasons))})" if reasons else ""
    parts = [f"{number} {decision}" for decision, number in count.items()]
    extra = [f"{len(story.lost_s)} lost"] if story.lost_s else []
    if story.final in _LATCHED and story.final is not None:
        extra.append(f"ends in {story.final.label}")
    return f"{len(story.grips)} grips: {', '.join(parts)}{why}{''.join(f', {text}' for text in extra)}"


def _of_grip(grip: Grip, story: Story) -> str:
    while_pending = f" while {display_name(grip.waiting)} was pending" if grip.waiting else ""
    of = f" of {grip.part}" if grip.part else ""
    match grip.decision:
        case GripDecision.GRIPPED:
            return _gripped(grip, story)
        case GripDecision.ABORTED if grip.culprit is not None:
            number = grip.of(grip.culprit)[-1].number
            attempts = "1 attempt" if number == 1 else f"{number} attempts"
            return f"{display_name(grip.culprit)} {_failed(grip)}: grip{of} ABORTED after {attempts}"
        case GripDecision.ABORTED:
            return f"Grip{of} ABORTED{while_pending}"
        case GripDecision.UNFINISHED:
            waiting = f": {display_name(grip.waiting)} still pending at the end" if grip.waiting else ""
            return f"Grip{of} UNFINISHED{waiting}"
        case _:
            return f"Grip{of} {grip.decision}{while_pending}"


def _failed(grip: Grip) -> str:
    """Return how the last attempt of an aborted grip failed."""
    empty = grip.failed and grip.failed[-1].outcome is AttemptOutcome.EMPTY
    return "gripped nothing" if empty else "never confirmed"


def _gripped(grip: Grip, story: Story) -> str:
    gripped = f"GRIPPED {grip.part}".rstrip()
    late = [(name, number) for name, number in grip.attempts_by_actuator.items() if number > 1]
    if late:
        first, *others = [(display_name(name), number) for name, number in late]
        more = "".join(f", {name} on attempt {number}" for name, number in others)
        return f"{first[0]} confirmed on attempt {first[1]}{more}: {gripped}"
    failed = story.lost_s or any(release.ended in _LATCHED for release in story.releases)
    return gripped if failed else f"Nominal: {gripped}"


def _aftermath(log: StatesLog, story: Story) -> list[str]:
    """Return the events after the grip was decided, in order of time."""
    causes = [release.cause for release in story.releases]
    held = "" if ReleaseCause.LOSS in causes else ": outputs held"
    parts = [(loss.time_s, f"then {loss.who} LOST{held}".replace("  ", " ")) for loss in story.losses]
    parts += [(each.time_s, "then resumed") for each in log.events or () if each.command == "resume"]
    kept = [grip for grip in story.grips if _HELD.get(grip.decision) not in (None, *causes)]
    parts += [(grip.decided_s or 0.0, "outputs held") for grip in kept]
    parts += [(release.start_s, _of_release(release, story)) for release in story.releases]
    return [text for _, text in sorted(parts, key=lambda part: part[0])]


def _of_release(release: Release, story: Story) -> str:
    done = "then dropped" if release.cause is ReleaseCause.DROP else "released"
    if release.ended is EndEffectorState.RELEASE_ERROR:
        return f"{'then ' if release.cause is ReleaseCause.DROP else ''}release failed: RELEASE_ERROR"
    if release.ended is None:
        return "still releasing at the end"
    if release.ended is EndEffectorState.GRIP_ERROR:  # the rest stays active, as declared
        return "partly released: GRIP_ERROR"
    if release.in_reverse(story.actuators):
        several = len(release.deactivated) > 1 and release.cause is not ReleaseCause.DROP
        return f"{done} in reverse order" if several else done
    return f"{done} in the order {', '.join(map(display_name, release.deactivated))}"


_TOGETHER_S = 0.2


def moments_of(log: StatesLog, story: Story, alarms: Sequence[AlarmRow] = ()) -> tuple[Moment, ...]:
    """Return the moments that a figure marks, in order of time.

    They are commands, time-outs, aborts, GRIPPED, losses, alarms and failed releases.
    """
    found = [
        Moment(each.time_s, "command", f"{each.command.upper()} {_gripped_by(log, each)}".rstrip())
        for each in log.events or ()
        if each.command
    ]
    for grip in story.grips:
        found += _grip_moments(grip)
    found += [
        Moment(loss.time_s, "lost", ": ".join(filter(None, ("grip lost", loss.who)))) for loss in story.losses
    ]
    found += _warnings(alarms)
    for release in story.releases:
        if release.ended is EndEffectorState.RELEASE_ERROR and release.end_s is not None:
            found.append(Moment(release.end_s, "lost", "release error"))
    return tuple(sorted(found, key=lambda moment: moment.time_s))


def _gripped_by(log: StatesLog, event: EventRow) -> str:
    """Return the part that a command is for; empty: none."""
    return log.part_at(event.time_s) if event.command == "grip" else ""


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


def _grip_moments(grip: Grip) -> list[Moment]:
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
