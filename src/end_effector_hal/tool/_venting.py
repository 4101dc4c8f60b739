"""An unlock waits for its proof that nothing is gripped any more (IL-01)."""

from __future__ import annotations

from end_effector_hal.control import Evidence, Status
from end_effector_hal.description import ToolChanger
from end_effector_hal.trace import EndEffectorState

from ._newest import Newest

FALL_S = 0.5
"""What a vacuum that has just been told gone takes to fall below what IL-01 asks for, at the longest."""
LAG_S = 0.15
"""So long the end of a release may be under way to this program: the other one has already reported it."""
_AT_REST = (EndEffectorState.STAND_BY, EndEffectorState.OFF)


def await_venting(newest: Newest, changer: ToolChanger) -> None:
    """Until it is proven or cannot be, for no longer than the fall and the proof take."""
    newest.wait(lambda status: _proven(status) or _vents(status), LAG_S)
    newest.wait(lambda status: _proven(status) or not _vents(status), changer.vented_s + FALL_S)


def _proven(status: Status) -> bool:
    return status.vented and status.ee in _AT_REST


def _vents(status: Status) -> bool:
    return status.ee in _AT_REST and all(level == Evidence.GONE for level in status.evidence)
