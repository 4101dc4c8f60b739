"""How long an unlock waits for the proof that nothing is gripped (IL-01)."""

from __future__ import annotations

from end_effector_hal.control import Status
from end_effector_hal.description import ToolChanger
from end_effector_hal.vocabulary import EndEffectorState

from ._latest_status import LatestStatus

FALL_S = 0.5
"""Longest time in which a vacuum that has just counted as gone falls below the limit of IL-01, s."""
LAG_S = 0.15
"""Longest delay until the end of a release is published, s."""
_MAY_RELEASE = (EndEffectorState.STAND_BY, EndEffectorState.OFF, EndEffectorState.RELEASING)


def await_release(latest: LatestStatus, changer: ToolChanger) -> None:
    """Wait until the release is proven or cannot be, for no longer than the fall and the proof take.

    Feedback that is still present is no reason to stop: the last frame of the release may not have arrived yet.
    """
    latest.wait(release_is_decided, longest_release_s(changer))


def longest_release_s(changer: ToolChanger) -> float:
    """Return the longest wait of an unlock, s."""
    return LAG_S + FALL_S + changer.vented_s


def release_is_decided(status: Status) -> bool:
    """Return whether the release is proven, or cannot be."""
    return status.vented or status.ee not in _MAY_RELEASE
