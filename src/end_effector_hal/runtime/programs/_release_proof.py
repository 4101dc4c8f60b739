"""An unlock waits for its proof that nothing is gripped any more (IL-01)."""

from __future__ import annotations

from end_effector_hal.control import Status
from end_effector_hal.description import ToolChanger
from end_effector_hal.vocabulary import EndEffectorState

from ._latest_status import LatestStatus

FALL_S = 0.5
"""What a vacuum that has just been told gone takes to fall below what IL-01 asks for, at the longest."""
LAG_S = 0.15
"""What shows the end of a release may be under way to this program for so long."""
_MAY_RELEASE = (EndEffectorState.STAND_BY, EndEffectorState.OFF, EndEffectorState.RELEASING)


def await_release(latest: LatestStatus, changer: ToolChanger) -> None:
    """Wait until the release is proven or cannot be, for no longer than the fall and the proof take.

    Feedback that is still there says nothing: the last frame of the release may not have come to this program yet.
    """
    latest.wait(release_is_decided, longest_release_s(changer))


def longest_release_s(changer: ToolChanger) -> float:
    """Seconds that an unlock waits at the longest."""
    return LAG_S + FALL_S + changer.vented_s


def release_is_decided(status: Status) -> bool:
    """Whether the release is proven, or cannot be."""
    return status.vented or status.ee not in _MAY_RELEASE
