"""Whether two recordings tell the same: the same states in the same order, each for about as long."""

from __future__ import annotations

from itertools import pairwise

from end_effector_hal.recording import StatesLog
from end_effector_hal.vocabulary import EndEffectorState

States = tuple[int, ...]

TOLERANCE_S = 0.1
"""Of each step: frames come every 20 ms, so that it may end one earlier or later; the rest is for a busy machine."""
MOMENT_S = 2e-6
"""Rows of one moment have one time; this is what rounding makes of it."""


def steps(log: StatesLog) -> list[tuple[States, float]]:
    """Each state (end-effector, then actuators) with how long it stood, from the first grip to its end.

    What is before depends on when the tool had adopted; the last state stands until the recording is closed. The
    command column is left out.
    """
    rows = [(row.time_s, (int(row.end_effector), *row.actuators)) for row in log.rows]
    begin = next((i for i, (_, state) in enumerate(rows) if state[0] == EndEffectorState.GRIPPING), None)
    if begin is None:
        return []
    changes = [rows[begin]]
    for row in rows[begin:]:
        if row[1] != changes[-1][1]:
            if row[0] - changes[-1][0] < MOMENT_S:  # passed through within one moment
                changes[-1] = (changes[-1][0], row[1])
            else:
                changes.append(row)
    ends = [after[0] - before[0] for before, after in pairwise(changes)]
    return list(zip([state for _, state in changes], [*ends, 0.0], strict=True))


def differences(one: StatesLog, other: StatesLog) -> list[float]:
    """By how many seconds each step of the other is longer; fails where the states are not the same."""
    mine, theirs = steps(one), steps(other)
    assert mine, "no grip was recorded"
    here, there = [state for state, _ in mine], [state for state, _ in theirs]
    assert here == there, f"the states here are {here}, there {there}"
    return [theirs_s - mine_s for (_, mine_s), (_, theirs_s) in zip(mine, theirs, strict=True)]


def same_story(one: StatesLog, other: StatesLog, tolerance_s: float = TOLERANCE_S) -> float:
    """The largest difference, s; fails where the states are not the same, or stand longer or shorter than that."""
    longer_s = differences(one, other)
    for (state, mine_s), more_s in zip(steps(one), longer_s, strict=True):
        told = f"{state} stood for {mine_s:.3f} s here and for {mine_s + more_s:.3f} s there"
        assert abs(more_s) <= tolerance_s, told
    return max(map(abs, longer_s))
