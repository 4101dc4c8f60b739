"""An unlock waits for its proof that nothing is gripped any more (IL-01)."""

from __future__ import annotations

from end_effector_hal.control import Evidence, Status
from end_effector_hal.description import ToolChanger

from ._newest import Newest

FALL_S = 0.5
"""What a vacuum that has just been told gone takes to fall below what IL-01 asks for, at the longest."""


def await_venting(newest: Newest, changer: ToolChanger) -> None:
    """Until it is proven or cannot be, for no longer than the fall and the proof take."""
    newest.wait(_vented_or_hopeless, changer.vented_s + FALL_S)


def _vented_or_hopeless(status: Status) -> bool:
    return status.vented or any(level != Evidence.GONE for level in status.evidence)
