"""Check a recorded run: replay it, and judge it with the monitor of its network."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from end_effector_hal.control import model_constants, network_of
from end_effector_hal.description import Description, content_hash, load
from end_effector_hal.errors import DescriptionError, ReportedError, UsageError
from end_effector_hal.runtime.boundary import OBSERVED, STATE
from timed_automata import Network, Step
from timed_automata.monitor import Monitor, Objection

from ._chain import Chain, SegmentEnd
from ._header import header_objections
from ._load import ProgramTrace
from ._replay import Replay, replay


class EdgePlaces:
    """Compares the recorded places of edges with the file.

    Args:
        network: the network of the file in the trace.
    """

    def __init__(self, network: Network) -> None:
        self._edges = {process.name: process.edges for process in network.processes}
        self._path: str | None = None

    def step(self, step: Step) -> Iterator[Objection]:
        """Yield objections to the places of a step's edges; their path, of the recording machine, must not change."""
        for taken in step.edges:
            edges = self._edges.get(taken.process, ())
            if not 0 <= taken.index < len(edges):
                continue  # the monitor says so
            path, place = _parted(taken.where)
            _, there = _parted(edges[taken.index].span.where)
            self._path = path if self._path is None else self._path
            who = f"{taken.process} {taken.source} → {taken.target}"
            if place != there:
                what = f"{who} is recorded at {place}, but the file has it at {there}."
                yield Objection(step.at, "no run", what)
            elif path != self._path:
                what = f"{who} is recorded in {path!r}, but other edges in {self._path!r}."
                yield Objection(step.at, "no run", what)


def _parted(where: str) -> tuple[str, str]:
    """Return the path, and ``line:column``."""
    path, line, column = (["", "", *where.rsplit(":", 2)])[-3:]
    return path, f"{line}:{column}"


@dataclass(frozen=True, slots=True)
class Review:
    """The results of the check of a trace.

    Attributes:
        trace: one segment.
        hash: hash of the description it was replayed with.
        replay: the result of the replay.
        steps: number of steps of the automata that the monitor followed.
        objections: objections of the monitor and of the other checks.
        requirements: number of the file's requirements that could be judged on the run.
        notes: sentences about changes since the recording, and about missing data.
        end: the end of the segment, for the review of the next one.
    """

    trace: ProgramTrace
    hash: str
    replay: Replay
    steps: int
    objections: tuple[Objection, ...]
    requirements: int
    notes: tuple[str, ...]
    end: SegmentEnd

    @property
    def ok(self) -> bool:
        """Whether the bytes are unchanged, the decisions are the same, and the run is one of its network.

        A missed bound that the program reported is no fault of the record.
        """
        same = self.replay.difference is None and all(o.kind == "missed" for o in self.objections)
        return same and not self.trace.file.damaged

    def as_json(self) -> dict[str, Any]:
        """Return the results as JSON, for programs; times in seconds since the beginning of the trace."""
        difference, seconds = self.replay.difference, self.trace.seconds
        return {
            "trace": str(self.trace.file.path),
            "ok": self.ok,
            "segment": self.trace.header.segment,
            "seconds": round(seconds(self.trace.last_at), 6),
            "recorded_hash": self.trace.header.hash,
            "replayed_hash": self.hash,
            "inputs": self.replay.inputs,
            "compared": self.replay.compared,
            "difference": difference
            and {
                "time_s": round(seconds(difference.at), 6),
                "what": difference.what,
                "recorded": difference.recorded,
                "replayed": difference.replayed,
                "recorded_name": difference.names[0],
                "replayed_name": difference.names[1],
            },
            "steps": self.steps,
            "requirements": self.requirements,
            "objections": [
                {"time_s": round(seconds(o.at), 6), "kind": o.kind, "what": o.what} for o in self.objections
            ],
            "notes": list(self.notes),
        }


def review(
    trace: ProgramTrace, description: Description | None = None, before: SegmentEnd | None = None
) -> Review:
    """Replay a trace and judge it.

    Args:
        trace: one segment.
        description: another tool than the recorded one; None: the recorded one.
        before: the end of the previous trace in the folder; a segment that follows it must begin there. None: the
            segment is judged alone, from the state it begins with.

    Raises:
        UsageError: a record cannot be read.
        ModelError: the automata cannot be executed.
    """
    try:
        return _reviewed(trace, description, before)
    except (ArithmeticError, LookupError, TypeError, ValueError) as error:
        if isinstance(error, ReportedError):
            raise
        what = f"A record has a valid form but impossible content: {type(error).__name__}: {error}."
        raise UsageError(what, where=str(trace.file.path)) from None


def _reviewed(trace: ProgramTrace, description: Description | None, before: SegmentEnd | None) -> Review:
    recorded_tool = trace.description()
    description = description or recorded_tool
    chain = Chain(trace, before)
    network = network_of(description)
    automata = description.automata
    monitor = Monitor(network, automata.executed, automata.interface, requirements=True)
    joint: list[Objection] = list(chain.objections)
    joint += header_objections(trace, recorded_tool)
    written, places = chain.lines(recorded_tool), EdgePlaces(network_of(recorded_tool))
    writes = [number for number, record in enumerate(trace.file.records) if record.kind == "lines"]
    for number, record in enumerate(trace.file.records):
        if record.kind in OBSERVED:
            observed = trace.typed(number)
            monitor.observe(observed)
            if isinstance(observed, Step):
                joint += places.step(observed)
        elif record.kind == "start":
            joint += written.begin(trace.typed(number))
        elif record.kind == "status":
            written.status(trace.typed(number))
        elif record.kind == "lines":
            joint += written.lines(trace.typed(number), final=number == writes[-1])
        elif record.kind == "arbiter" and not trace.typed(number).there:
            written.lose()
        elif record.kind == STATE:
            recorded = trace.typed(number).execution
            monitor.resume(recorded)
            joint += chain.compare(recorded)
    last_at = trace.last_at
    if trace.file.complete:
        monitor.end(last_at)
    used = content_hash(description)
    replayed = replay(trace, description, network, chain.state)
    if replayed.difference is not None:
        replayed = replace(replayed, difference=replayed.difference.named(description))
    complete, header = trace.file.complete, trace.header
    return Review(
        trace,
        used,
        replayed,
        monitor.steps,
        (*joint, *monitor.objections),
        len(monitor.queries),
        (*chain.notes, *_notes(trace, description, used)),
        SegmentEnd(
            header.run,
            header.segment,
            complete,
            replayed.end,
            monitor.snapshot if complete else None,
            written,
            trace.file.path,
        ),
    )


def _notes(trace: ProgramTrace, description: Description, used: str) -> list[str]:
    header, notes = trace.header, []
    if trace.file.note:
        notes.append(f"The trace is {'damaged' if trace.file.damaged else 'not whole'}: {trace.file.note}.")
    constants = model_constants(description)
    if names := [key for key, value in constants.items() if header.constants.get(key) != value]:
        notes.append(f"Replayed with other constants of the model than recorded: {', '.join(names)}.")
    if used != header.hash and description.source.name != "description.json":
        notes.append(f"Replayed with another description ({used}) than recorded ({header.hash}).")
    elif (now := _hash_of(Path(header.source))) not in (None, header.hash):
        notes.append(
            f"{header.source} or its automata have changed since ({header.hash}, now {now}); "
            "--description replays with them as they are."
        )
    return notes


def _hash_of(source: Path) -> str | None:
    try:
        return content_hash(load(source)) if source.is_file() else None
    except (DescriptionError, OSError, ValueError):
        return "not readable"
