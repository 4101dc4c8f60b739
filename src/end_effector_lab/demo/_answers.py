"""What the tool answered to the commands of a run: why one was refused."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from end_effector_hal.errors import ReportedError
from end_effector_hal.verification.replay import load_trace, traces_of

from ._finding import Finding

TAKEN = "every command taken"


def answered(folder: Path) -> Finding:
    """Every command that its program refused, with the reason in the words that a client got."""
    try:
        refused = [each for path in traces_of(folder) for each in _refused(path)]
    except (ReportedError, KeyError) as error:
        refused = [str(error)]
    return Finding("answers", TAKEN, "; ".join(refused) or TAKEN, not refused)


def _refused(path: Path) -> Iterator[str]:
    command, trace = "", load_trace(path)
    for number, record in enumerate(trace.file.records):
        if record.kind == "command":
            command = str(trace.content(number)["name"])
        elif record.kind == "answer" and not (answer := trace.content(number))["accepted"]:
            yield f"{command} was refused: {answer['reason']}"
