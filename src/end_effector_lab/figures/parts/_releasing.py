"""The time at which a deactivated actuator is detected as gone, in seconds since start."""

from __future__ import annotations

from bisect import bisect_right
from math import inf

from end_effector_hal.kinds import recorded_kind
from end_effector_hal.recording import PressuresLog, RunInfo, StatesLog
from end_effector_hal.vocabulary import INACTIVE, EndEffectorState


def gone_s(
    name: str, deactivated_s: float, log: StatesLog, info: RunInfo, pressures: PressuresLog | None
) -> float:
    """Return when the feedback of an actuator was gone: by its pressure, else by the next step of the release.

    The time is infinite if that never happened, and the time of the deactivation if nothing shows it, or if nothing
    was deactivated: a program that starts (OFF) has no active actuators.
    """
    if log.rows[bisect_right(log.times_s, deactivated_s) - 1].end_effector is EndEffectorState.OFF:
        return deactivated_s
    limit = info.limits.get(name, {})
    channel, gone_kpa = limit.get("channel"), limit.get("gone_kpa")
    if pressures is not None and channel in pressures.channels and isinstance(gone_kpa, int | float):
        sign = -1 if recorded_kind(name, info.actuators).below_ambient else 1
        first = max(bisect_right(pressures.times_s, deactivated_s) - 1, 0)
        later = zip(pressures.times_s[first:], pressures.curve(str(channel))[first:], strict=True)
        known = [(at, kpa) for at, kpa in later if kpa is not None]
        if known:
            return next((max(at, deactivated_s) for at, kpa in known if sign * kpa < gone_kpa), inf)
    return _went_on_s(deactivated_s, log)


def _went_on_s(deactivated_s: float, log: StatesLog) -> float:
    """Return when the next actuator was deactivated or RELEASING ended; if not RELEASING, the given time."""
    first = bisect_right(log.times_s, deactivated_s)
    before = log.rows[first - 1]
    if before.end_effector is not EndEffectorState.RELEASING:
        return deactivated_s
    for row in log.rows[first:]:
        switched = any(
            new == INACTIVE != old for old, new in zip(before.actuators, row.actuators, strict=True)
        )
        if switched or row.end_effector is not EndEffectorState.RELEASING:
            return row.time_s
        before = row
    return inf
