"""An unlock waits for its proof that nothing is gripped any more (IL-01)."""

from __future__ import annotations

from collections.abc import Callable

from end_effector_hal.control import Evidence, Status
from end_effector_hal.description import ToolChanger
from end_effector_hal.trace import EndEffectorState
from end_effector_hal.wires import now_us

from ._newest import Newest

FALL_S = 0.5
"""What a vacuum that has just been told gone takes to fall below what IL-01 asks for, at the longest."""
LAG_S = 0.15
"""What shows the end of a release may be under way to this program for so long, or come and go at the threshold."""
_AT_REST = (EndEffectorState.STAND_BY, EndEffectorState.OFF)


def await_venting(newest: Newest, changer: ToolChanger, clock: Callable[[], int] = now_us) -> None:
    """Until it is proven or cannot be, for no longer than the fall and the proof take."""
    end = clock() + round((LAG_S + FALL_S + changer.vented_s) * 1e6)
    while not _proven(newest.status) and not newest.ended and (left := end - clock()) > 0:
        if _vents(newest.status):
            newest.wait(lambda status: _proven(status) or not _vents(status), left / 1e6)
        elif not newest.wait(lambda status: _proven(status) or _vents(status), min(LAG_S, left / 1e6)):
            return


def _proven(status: Status) -> bool:
    return status.vented and status.ee in _AT_REST


def _vents(status: Status) -> bool:
    return status.ee in _AT_REST and all(level == Evidence.GONE for level in status.evidence)
