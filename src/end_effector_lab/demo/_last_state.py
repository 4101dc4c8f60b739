"""How far a recording is, while it is being written."""

from __future__ import annotations

import os
from pathlib import Path

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import StatesLog, StatesRow, read_states
from end_effector_hal.vocabulary import EndEffectorState


def last_row(path: Path) -> tuple[StatesLog, StatesRow] | None:
    """The recording and its newest whole row; None: nothing is there yet."""
    if not path.exists() or os.path.getsize(path) == 0:
        return None
    try:
        log = read_states(path)
    except UsageError:
        return None  # its header is being written
    return (log, log.rows[-1]) if log.rows else None


def last_state(path: Path) -> EndEffectorState | None:
    """The newest state of the end-effector; None: nothing is there yet."""
    found = last_row(path)
    return found[1].end_effector if found else None
