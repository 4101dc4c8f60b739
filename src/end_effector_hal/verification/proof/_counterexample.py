"""A run that refutes a requirement, as files: text with absolute times, and what a recorded run has."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import RunInfo, StatesLog, StatesWriter
from end_effector_hal.verification._model_run import has_states, states_of
from timed_automata import Trace

from ._finding import Finding

Draw = Callable[[StatesLog, RunInfo, Path], list[Path]]


def write_counterexample(
    finding: Finding, folder: str | Path, info: RunInfo, draw: Draw, actuators: Sequence[str] = ()
) -> list[Path]:
    """Write ``<id>/run.txt``, and ``states.csv``, ``run.json`` and the timeline if the model has their variables.

    Args:
        finding: with a trace.
        folder: made if it is missing.
        info: what the figure says about the model.
        draw: writes the timeline of the states into a folder and returns its files.
        actuators: their names in sequence order.

    Raises:
        UsageError: the folder cannot be written.
    """
    trace = finding.trace
    if trace is None:
        return []
    place = Path(folder) / finding.id
    try:
        place.mkdir(parents=True, exist_ok=True)
        text = place / "run.txt"
        text.write_text("\n".join((finding.sentence, finding.query, "", *trace.lines, "")), encoding="utf-8")
    except OSError as error:
        raise UsageError(f"Cannot be written: {error.strerror}.", where=str(place)) from None
    if not has_states(trace.network):
        return [text]
    return [text, *_recording(finding, trace, place, info, draw, actuators)]


def _recording(
    finding: Finding, trace: Trace, place: Path, info: RunInfo, draw: Draw, actuators: Sequence[str]
) -> list[Path]:
    log = states_of(trace, actuators)
    info = replace(info, scenario=f"counterexample: {finding.sentence}", simulated=True)
    states = place / "states.csv"
    states.unlink(missing_ok=True)
    with StatesWriter(states, log.actuators) as writer:
        for row in log.rows:
            writer.write(row.time_s, row.end_effector, row.command, row.actuators)
    return [states, info.write(place), *draw(log, info, place)]
