"""Verify models and recorded runs: proofs and replays.

Here a run of a model becomes the recording that a real run with the same states would produce.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from end_effector_hal.control import EventReader
from end_effector_hal.errors import UsageError, os_errors
from end_effector_hal.recording import (
    EventRow,
    EventsWriter,
    RunFile,
    RunInfo,
    StatesLog,
    StatesRow,
    StatesWriter,
    event_row,
)
from end_effector_hal.vocabulary import ActuatorState, Command, EndEffectorState
from timed_automata import Network, State, Step, TakenEdge, Trace

_EXECUTED = ("Gripper", "Changer")


def has_states(network: Network) -> bool:
    """Return whether a network has the variables that a recording needs: ``ee``, ``command``, ``actuator[]``."""
    return {"ee", "command", "actuator[0]"} <= set(network.offsets)


def states_of(trace: Trace, actuators: Sequence[str] = ()) -> StatesLog:
    """Return the states and events of a run, in seconds since its start: a row per change, and one at the end.

    Args:
        trace: a run of a network for which :func:`has_states` is true.
        actuators: names in sequence order; by default ``actuator_0``, ``actuator_1``, …

    Raises:
        UsageError: a value is not in Table II, or the number of names differs from the number of actuators.
    """
    network = trace.network
    columns = [name for name in network.offsets if name.startswith("actuator[")]
    names = tuple(actuators) or tuple(f"actuator_{number}" for number in range(len(columns)))
    if len(names) != len(columns):
        raise UsageError(f"{len(names)} names for the {len(columns)} actuators of the model.")
    rows = [_row(network, columns, network.initial, 0.0)]
    for step in trace.steps:
        row = _row(network, columns, step.state, float(step.at) / 1000)
        if row.states != rows[-1].states:
            rows.append(row)
    end = float(trace.end) / 1000
    if end > rows[-1].time_s:
        last = rows[-1]
        rows.append(StatesRow(end, last.end_effector, last.command, last.actuators))
    return StatesLog(names, tuple(rows), events=_events(trace, names))


Draw = Callable[[StatesLog, RunInfo, Path], list[Path]]
"""Writes the timeline of a run into a folder; returns its files."""


def write_run(
    folder: Path, lines: Iterable[str], run: tuple[StatesLog, RunInfo] | None, draw: Draw
) -> list[Path]:
    """Write a run of a model as ``run.txt``, and its states as a recording has them; existing files are replaced.

    Args:
        folder: made if it is missing.
        lines: the run as text.
        run: its states, and what ``run.json`` says of them; None: the model has no states.
        draw: draws the timeline of the states.

    Raises:
        UsageError: the files cannot be written.
    """
    text = folder / "run.txt"
    with os_errors("Cannot be written", folder):
        folder.mkdir(parents=True, exist_ok=True)
        text.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
    if run is None:
        return [text]
    log, info = run
    described = info.write(folder)  # first: it says whose the others are
    states, events = folder / RunFile.STATES, folder / RunFile.EVENTS
    for each in (states, events):
        each.unlink(missing_ok=True)
    with StatesWriter(states, log.actuators) as writer:
        for row in log.rows:
            writer.write(row.time_s, row.end_effector, row.command, row.actuators)
    with EventsWriter(events, log.actuators) as table:
        table.write(log.events or ())
    return [text, states, events, described, *draw(log, info, folder)]


def _events(trace: Trace, names: Sequence[str]) -> tuple[EventRow, ...]:
    processes, reader = trace.network.processes, EventReader()
    found: list[EventRow] = []
    for step in trace.steps:
        edges = tuple(
            TakenEdge(process.name, process.locations[edge.source].name, process.locations[edge.target].name, 0, "")
            for edge in step.edges
            if (process := processes[edge.process]).name in _EXECUTED
        )  # fmt: skip
        at_s = float(step.at) / 1000
        taken = Step(round(at_s * 1e6), None, 0, False, step.channel, None, edges, step.changes)
        found += (event_row(event, at_s, names) for event in reader.of(taken, taken.at))
    return tuple(found)


def _row(network: Network, columns: list[str], state: State, time_s: float) -> StatesRow:
    values = [state.values[network.offsets[name]] for name in ("ee", "command", *columns)]
    try:
        return StatesRow(
            round(time_s, 6),
            EndEffectorState(values[0]),
            Command(values[1]),
            tuple(int(ActuatorState(value)) for value in values[2:]),
        )
    except ValueError as error:
        raise UsageError(f"Not in Table II: {error}.", where=network.document.path) from None
