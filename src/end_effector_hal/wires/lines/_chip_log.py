"""The file of a virtual chip: a header and a record per change, as JSON lines. Pure: text in, edges out.

    {"chip": "verdin", "version": 1, "t": 5, "lines": {"SODIMM_206": "down", "SODIMM_208": "up"}}
    {"t": 90210, "line": "SODIMM_208", "direction": "out", "level": 0, "pid": 4711}

``t`` is µs on the monotonic clock; the header lists each line with its pull. A line that is not complete JSON was torn
by the death of its writer and is ignored.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

Direction = Literal["in", "out"]


class Edge(NamedTuple):
    """A change of a line's direction or level.

    Attributes:
        at: µs, on the writer's clock.
        line: name of the line.
        direction: "in" or "out".
        level: level of the pin; for an input, the level of its pull.
        pid: process that wrote the record.
    """

    at: int
    line: str
    direction: Direction
    level: bool
    pid: int

    @property
    def active(self) -> bool:
        """Whether the line is driven high, which is a command; an input that its pull holds high is none."""
        return self.direction == "out" and self.level


class LineState(NamedTuple):
    """Direction and level of a line."""

    direction: Direction
    level: bool


@dataclass(frozen=True)
class ChipState:
    """The state of a chip: its label, and the state of each line by name."""

    label: str = ""
    lines: Mapping[str, LineState] = field(default_factory=dict)


def header(label: str, pulls: Mapping[str, str], at: int) -> bytes:
    """Return the first line of the file for a chip that was just powered up."""
    return _line({"chip": label, "version": 1, "t": at, "lines": dict(pulls)})


def record(edge: Edge) -> bytes:
    """Return one line of the log."""
    at, line, direction, level, pid = edge
    return _line({"t": at, "line": line, "direction": direction, "level": int(level), "pid": pid})


class ChipLog:
    """Parses the text of a chip's file; ``state`` is the result so far."""

    def __init__(self) -> None:
        self._label = ""
        self._lines: dict[str, LineState] = {}
        self._rest = b""

    @property
    def state(self) -> ChipState:
        """The state after the last feed."""
        return ChipState(self._label, dict(self._lines))

    def start_new_file(self) -> None:
        """Prepare for another file. The state is kept, so that its header gives edges only for lines that differ."""
        self._rest = b""

    def feed(self, data: bytes) -> list[Edge]:
        """Return the edges of the records that end in ``data``; a header gives an edge for each line whose state it
        changes.
        """
        *lines, self._rest = (self._rest + data).split(b"\n")
        edges: list[Edge] = []
        for line in lines:
            try:
                entry = json.loads(line)
                edges += self._header(entry) if "chip" in entry else [self._record(entry)]
            except (ValueError, TypeError, KeyError, AttributeError):
                continue
        return edges

    def _header(self, entry: dict[str, Any]) -> list[Edge]:
        fresh = {str(name): LineState("in", pull == "up") for name, pull in entry["lines"].items()}
        changed = {name: state for name, state in fresh.items() if self._lines.get(name) != state}
        self._label, self._lines = str(entry["chip"]), fresh
        return [Edge(int(entry["t"]), name, *state, 0) for name, state in changed.items()]

    def _record(self, entry: dict[str, Any]) -> Edge:
        direction: Direction = "out" if entry["direction"] == "out" else "in"
        edge = Edge(int(entry["t"]), entry["line"], direction, bool(entry["level"]), int(entry["pid"]))
        if edge.line not in self._lines:
            raise KeyError(edge.line)
        self._lines[edge.line] = LineState(direction, edge.level)
        return edge


def _line(entry: Mapping[str, object]) -> bytes:
    return json.dumps(entry, separators=(",", ":")).encode() + b"\n"
