"""A unit with its connection to the line owner."""

from __future__ import annotations

import logging
from pathlib import Path

from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError

from ._owner import connect_owner
from ._sensor_fault import SensorFault
from ._unit import Listener, Unit
from .boundary import NOBODY, Recorder, open_recorder

_log = logging.getLogger("end_effector_hal.tool")


def open_unit(
    description: Description,
    program: str,
    on_status: Listener | None = None,
    *,
    patience_s: float = 5.0,
    traces: str | Path | None = None,
) -> Unit:
    """A unit that is not started yet; it keeps its lease at the owner only while it works.

    ``traces``: the folder that gets its trace; None: nothing is recorded. One that cannot be written is told in the
    log: a full disk is no reason not to hold a part.

    Raises:
        OwnerError: there is no line owner.
        LineBusyError: another process runs this program; says who.
    """
    lines = connect_owner(description, program, patience_s=patience_s)
    try:
        recorder = _recorder(traces, description, program) if traces is not None else NOBODY
        fault = SensorFault(lines) if program == "tool_change" else None
        unit = Unit(description, program, lines, on_status, recorder, fault)
        lines.attend(alive=lambda: unit.alive, on_lost=unit.lost, on_faults=unit.latched)
    except BaseException:  # Ctrl-C, too: who leaves in order has not died
        lines.close(())
        raise
    return unit


def _recorder(folder: str | Path, description: Description, program: str) -> Recorder:
    try:
        return open_recorder(folder, description, program)
    except UsageError as error:
        _log.error("no trace of %s is recorded: %s", program, error)
        return NOBODY
