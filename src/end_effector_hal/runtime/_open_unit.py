"""A unit with its connection to the line arbiter."""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.description import Description
from end_effector_hal.recording import RecordingLimits

from ._arbiter import connect_arbiter
from ._newest import Listener
from ._sensor_fault import SensorFault
from ._unit import Unit
from .boundary import NOBODY, open_recorder


def open_unit(
    description: Description,
    program: str,
    on_status: Listener | None = None,
    *,
    patience_s: float = 5.0,
    traces: str | Path | None = None,
    limits: RecordingLimits | None = None,
) -> Unit:
    """A unit that is not started yet; it keeps its lease at the owner only while it works.

    ``traces``: the folder that gets its trace, within ``limits``; None: nothing is recorded. One that cannot be written
    is an alarm: a full disk is no reason not to hold a part.

    Raises:
        ArbiterError: there is no line arbiter.
        LineBusyError: another process runs this program; says who.
    """
    lines = connect_arbiter(description, program, patience_s=patience_s)
    try:
        recorder = NOBODY
        if traces is not None:
            recorder = open_recorder(traces, description, program, limits=limits)
        fault = SensorFault(lines) if program == "tool_change" else None
        unit = Unit(description, program, lines, on_status, recorder, fault)
        lines.attend(alive=lambda: unit.alive, on_lost=unit.lost, on_faults=unit.latched)
    except BaseException:  # Ctrl-C, too: who leaves in order has not died
        lines.close(())
        raise
    return unit
