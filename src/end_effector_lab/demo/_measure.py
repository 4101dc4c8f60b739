"""The times of a recording beside those of the description."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

from end_effector_hal.description import Description
from end_effector_hal.recording import StatesLog, Story

from ._finding import Measure


def measures(
    description: Description, log: StatesLog, story: Story, slow_release: str | None
) -> list[Measure]:
    """Every time-out and reset of the recording, and the wait for ``slow_release`` while unwinding."""
    parts = description.actuators
    found = [
        Measure(f"{attempt.actuator} time-out {attempt.number}", parts[attempt.actuator].timeout_s, length)
        for attempt in story.timeouts
        if (length := attempt.length_s) is not None
    ]
    count: Counter[str] = Counter()
    for reset in story.resets:
        count[reset.actuator] += 1
        name = f"{reset.actuator} reset {count[reset.actuator]}"
        found.append(Measure(name, parts[reset.actuator].reset_s, reset.length_s))
    waited = _release_wait(log, slow_release) if slow_release else None
    if slow_release and waited is not None:
        found.append(Measure(f"{slow_release} release", parts[slow_release].release_s, waited))
    return found


def _release_wait(log: StatesLog, actuator: str) -> float | None:
    """From its last deactivation to the next change of the states; None: it is not recorded."""
    index = log.actuators.index(actuator)
    changes = [
        i
        for i, (old, new) in enumerate(pairwise(log.rows), 1)
        if old.actuators[index] and not new.actuators[index]
    ]
    after = changes[-1] + 1 if changes else len(log.rows)
    return log.rows[after].time_s - log.rows[changes[-1]].time_s if after < len(log.rows) else None
