"""Extract the attempts of grips from recorded runs, and evaluate them with detectors of other values."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from end_effector_hal.codecs import carrier_of
from end_effector_hal.control import Status
from end_effector_hal.description import Description
from end_effector_hal.kinds import detector_of
from end_effector_hal.kinds.stanza import Actuator, Supply
from end_effector_hal.runtime.boundary import FrameTaken
from end_effector_hal.runtime.stream import PUBLISHED
from end_effector_hal.sensing import SensorState
from end_effector_hal.signals import Frame, Kind
from end_effector_hal.verification.replay import Entry
from end_effector_hal.vocabulary import ACTIVE, EndEffectorState, Evidence, to_us

MOST_READINGS = 300_000
"""Maximum number of readings in all recordings together, to bound memory: 100 minutes of grips at 50 frames
a second.
"""
MOST_GRIPS = 10_000
AFTER_US = 30_000_000
"""Longest time for which an actuator is watched after its deactivation, µs."""
THINNED_US, REPEAT_US = 600_000, 20_000
"""Longest gap that is filled and interval of the repeated frames, µs: tables leave out steady pressures for half a
second.
"""


class RecordedReadings:
    """Values of the channels at one instant, for a detector; stale and invalid values are absent.

    Attributes:
        at: time, µs.
        carried: the channels of the codec.
        fresh: the values, gauge Pa or a bit.
        arrived: the channels of a frame that arrived at this instant.
    """

    __slots__ = ("arrived", "at", "carried", "fresh")

    def __init__(
        self, at: int, carried: Mapping[str, Kind], values: Mapping[str, int | bool], arrived: frozenset[str]
    ) -> None:
        self.at, self.carried = at, carried
        self.fresh, self.arrived = values, arrived

    def get(self, channel: str | None, at: int) -> int | bool | None:
        """Return the value in gauge Pa, or the bit; None: there was none."""
        return None if channel is None else self.fresh.get(channel)


@dataclass(slots=True)
class RecordedAttempt:
    """One activation of an actuator within a grip; times in µs.

    Attributes:
        since: when it became active.
        until: when it became inactive; None: it was active to the end of the recording.
        confirmed: when the recorded tool confirmed it; None: it did not.
        readings: from ``since`` until it is active again, or `AFTER_US` after it was deactivated.
        seen_until: time of the last reading.
    """

    since: int
    until: int | None = None
    confirmed: int | None = None
    readings: list[RecordedReadings] = field(default_factory=list)
    seen_until: int = 0


@dataclass(slots=True)
class RecordedGrip:
    """A recorded grip, with the attempts of each actuator.

    Attributes:
        recording: number of the recording.
        since: when GRIPPING began, µs.
        part: name of the part; empty: it has none.
        activations: by actuator, in order of time.
    """

    recording: int
    since: int
    part: str = ""
    activations: dict[str, list[RecordedAttempt]] = field(default_factory=dict)


class GripCollector:
    """Collects the grips of several recordings.

    Args:
        description: the tool, which decides whether readings are fresh and plausible.

    Attributes:
        grips: in the order of the recordings and of time.
        full: whether the limit of grips or readings was reached.
    """

    def __init__(self, description: Description) -> None:
        self._description, self._readings = description, 0
        self.grips: list[RecordedGrip] = []
        self.full = False

    def collect(self, entries: Iterable[Entry], recording: int) -> int:
        """Read the records of one recording, up to the limit; return the number of grips that were added."""
        before = len(self.grips)
        one = _OneRecording(self._description, recording)
        for entry in entries:
            if entry.record is None:
                continue
            if entry.kind == "start":
                one.restart(entry.at)
            elif entry.kind == "frame":
                self._readings += one.frame(entry.record)
            elif entry.kind in ("status", PUBLISHED):
                status = entry.record.status if entry.kind == PUBLISHED else entry.record
                if (grip := one.status(status)) is not None:
                    if len(self.grips) >= MOST_GRIPS:
                        self.full = True
                        break
                    self.grips.append(grip)
            if self._readings > MOST_READINGS:
                self.full = True
                break
        return len(self.grips) - before


class _OneRecording:
    """Follows one run: its sensors, and its active actuators."""

    def __init__(self, description: Description, recording: int) -> None:
        self._description, self._recording, self._carrier = description, recording, carrier_of(description)
        self._names = description.sequence
        self._open: dict[str, RecordedAttempt] = {}
        self._grip: RecordedGrip | None = None
        self._before: Status | None = None
        self._sensors = SensorState(description, self._carrier)
        self._last: FrameTaken | None = None
        self._seen_at = 0

    def restart(self, at: int) -> None:
        """Handle a start or restart of the program, after which active actuators are unknown."""
        self._open.clear()
        self._grip = self._before = None
        self._sensors, self._last = SensorState(self._description, self._carrier), None

    def frame(self, record: FrameTaken) -> int:
        """Add the readings of a frame; return how many were kept."""
        kept, last = 0, self._last
        if record.stamp > record.at or (last is not None and record.stamp <= last.stamp):
            return 0  # its stamp is impossible: the tool did not count it either
        if last is not None and record.seq is None and record.device_ms is None:
            gap = record.stamp - last.stamp
            if 3 * REPEAT_US < gap <= THINNED_US and last.seq is None:
                for at in range(last.stamp + REPEAT_US, record.stamp - REPEAT_US // 2, REPEAT_US):
                    kept += self._see(Frame(at, None, None, last.values))
        self._last = record
        return kept + self._see(record.frame)

    def status(self, status: Status) -> RecordedGrip | None:
        """Process a status; return the grip that begins with it, or None."""
        before, self._before = self._before, status
        begun: RecordedGrip | None = None
        if before is None or len(status.outputs) != len(self._names):
            return None
        if status.ee is EndEffectorState.GRIPPING is not before.ee:
            begun = self._grip = RecordedGrip(self._recording, status.at, status.part)
            self._open.clear()
        for index, name in enumerate(self._names):
            is_on, was_on = status.outputs[index], before.outputs[index]
            if is_on and not was_on:
                self._activated(name, status)
            elif was_on and not is_on and (found := self._open.get(name)):
                found.until = status.at
            found = self._open.get(name)
            if (
                found
                and found.until is None
                and found.confirmed is None
                and status.actuators[index] == ACTIVE
            ):
                found.confirmed = status.at
        return begun

    def _activated(self, name: str, status: Status) -> None:
        self._open.pop(name, None)
        if self._grip is not None and status.ee is EndEffectorState.GRIPPING:
            self._open[name] = RecordedAttempt(status.at, seen_until=status.at)
            self._grip.activations.setdefault(name, []).append(self._open[name])

    def _see(self, frame: Frame) -> int:
        kept, sensors, last = 0, self._sensors, self._seen_at
        while (due := sensors.deadline(last)) is not None and due < frame.at:
            sensors.wait(due)
            kept += self._keep(due)
            last = due
        for _ in sensors.take(frame):
            kept += self._keep(frame.at)
        return kept

    def _keep(self, at: int) -> int:
        self._seen_at = at
        done = [
            name for name, each in self._open.items() if each.until is not None and at > each.until + AFTER_US
        ]
        for name in done:
            del self._open[name]
        if not self._open:
            return 0
        readings, carried = self._sensors.readings, self._carrier.channels
        values: dict[str, Any] = {}
        for channel in carried:
            value = readings.get(channel, at)
            if value is not None:
                values[channel] = value
        arrived = readings.arrived.intersection(values)
        then = RecordedReadings(at, carried, values, arrived)
        for each in self._open.values():
            each.readings.append(then)
            each.seen_until = at
        return 1


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
