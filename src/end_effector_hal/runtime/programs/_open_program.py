"""Open a program with its connection to the line arbiter."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TypeVar

from end_effector_hal.arbiter import connect_arbiter
from end_effector_hal.description import Description
from end_effector_hal.recording import RecordingLimits
from end_effector_hal.runtime.boundary import Observer, Recorder, open_recorder, open_stream
from end_effector_hal.sensing import FrameJudge

from ._latest_status import Listener
from ._program import Program

P = TypeVar("P", bound=Program)


def open_program(
    program: type[P],
    description: Description,
    on_status: Listener | None = None,
    *,
    patience_s: float = 5.0,
    traces: str | Path | None = None,
    limits: RecordingLimits | None = None,
    judge: FrameJudge | None = None,
    observe: Observer | None = None,
) -> P:
    """Return a program that is not started yet; it keeps its lease at the arbiter only while it works.

    Args:
        program: GripProgram or ChangerProgram.
        description: the tool.
        on_status: called with each status.
        patience_s: longest wait for an arbiter to appear.
        traces: the folder for its trace; None: nothing is recorded. If the folder cannot be written, the program
            raises an alarm and goes on: a full disk is no reason not to hold a part.
        limits: the recording limits of that folder.
        judge: shared by all parts of this process that get the same frames.
        observe: called with each record of the program.

    Raises:
        ArbiterError: there is no line arbiter.
        LineBusyError: another process runs this program; the error names it.
    """
    lines = connect_arbiter(description, program.NAME, patience_s=patience_s)
    try:
        stream = open_stream(description, program.NAME)
        shown = None if observe is None else partial(observe, program.NAME)
        recorder = Recorder(stream=stream, observe=shown)
        if traces is not None:
            recorder = open_recorder(
                traces, description, program.NAME, limits=limits, stream=stream, observe=shown
            )
        opened = program(description, lines, on_status, recorder, judge=judge)
        lines.attend(alive=lambda: opened.alive, on_lost=opened.arbiter_lost, on_faults=opened.faults_changed)
    except BaseException:  # Ctrl-C, too: who leaves in order has not died
        lines.close(())
        raise
    return opened
