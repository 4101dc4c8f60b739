"""Open a program with its connection to the line arbiter."""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.arbiter import HAL, PredicatePublisher, connect_arbiter
from end_effector_hal.description import Description
from end_effector_hal.recording import RecordingLimits
from end_effector_hal.runtime.boundary import Observer, Recorder, open_recorder, open_stream

from ._latest_status import Listener
from ._program import Program


def open_program(
    description: Description,
    on_status: Listener | None = None,
    *,
    traces: str | Path | None = None,
    limits: RecordingLimits | None = None,
    publisher: PredicatePublisher | None = None,
    observe: Observer | None = None,
) -> Program:
    """Return a program that is not started yet; it keeps its lease at the arbiter only while it works.

    Args:
        description: the tool.
        on_status: called with each status.
        traces: the folder for its trace; None: nothing is recorded. If the folder cannot be written, the program
            raises an alarm and goes on: a full disk is no reason not to hold a part.
        limits: the recording limits of that folder.
        publisher: sends what its sensors prove to the line arbiter; None: another process does.
        observe: called with each record of the program.

    Raises:
        ArbiterError: there is no line arbiter.
        LineBusyError: another process runs this program; the error names it.
    """
    lines = connect_arbiter(description, HAL)
    try:
        stream = open_stream(description)
        recorder = Recorder(stream=stream, observe=observe)
        if traces is not None:
            recorder = open_recorder(traces, description, limits=limits, stream=stream, observe=observe)
        opened = Program(description, lines, on_status, recorder, publisher=publisher)
        lines.attend(alive=lambda: opened.alive, on_lost=opened.arbiter_lost, on_faults=opened.faults_changed)
    except BaseException:  # Ctrl-C, too: who leaves in order has not died
        lines.close(())
        raise
    return opened
