"""What a trace is made of; all times are µs on the monotonic clock.

Inputs of the controller, its outputs, and what its automata saw and did. The fields: `docs/reference/recordings.md`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from end_effector_hal.control import ControllerSnapshot, Status
from end_effector_hal.recording import Gap
from timed_automata import Begun, Received, Step, Written


@dataclass(frozen=True, slots=True)
class Header:
    """Where a trace comes from: the first record of each segment."""

    at: int
    program: str
    description: str
    """Name of the tool."""
    hash: str
    """Of the description and its automata, as in run.json."""
    model: str
    """Of the UPPAAL file."""
    version: str
    started: str
    """ISO 8601."""
    source: str
    """The file of the description."""
    constants: Mapping[str, Any]
    """What was put into the model."""
    run: str
    """The same in all segments of one start of the program."""
    segment: int = 1
    """Number of the segment since that start."""
    follows: bool = False
    """The segment before it was closed in good order, and nothing is missing between the two."""
    gap: Gap | None = None
    """What is missing before it."""


@dataclass(frozen=True, slots=True)
class Start:
    """A controller is made and begins, with the levels of the lines as they were found."""

    at: int
    levels: Mapping[str, bool]
    sensor_fault: bool = False
    """One of the tool changer was latched before."""


@dataclass(frozen=True, slots=True)
class FrameTaken:
    """A frame that came at ``stamp`` is taken at ``at``; Pa (gauge) and bits, null: carried, but invalid."""

    at: int
    stamp: int
    seq: int | None
    device_ms: int | None
    values: Mapping[str, int | bool | None]


@dataclass(frozen=True, slots=True)
class Commanded:
    """A command, by the name of its channel."""

    at: int
    name: str


@dataclass(frozen=True, slots=True)
class PeerUpdate:
    """Another program has sent its interface variables."""

    at: int
    values: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class ActivationRefused:
    """The line arbiter refused to activate what the last status asked for."""

    at: int


@dataclass(frozen=True, slots=True)
class Acknowledged:
    """Alarms that are over were seen."""

    at: int


@dataclass(frozen=True, slots=True)
class TimeAdvanced:
    """Time has passed until ``at``."""

    at: int


@dataclass(frozen=True, slots=True)
class Answered:
    """What became of the command before it."""

    at: int
    accepted: bool
    reason: str


@dataclass(frozen=True, slots=True)
class LinesWritten:
    """Levels and the will that were given to the line arbiter at ``at``, and how long that took."""

    at: int
    took_us: int
    levels: Mapping[str, bool]
    will: tuple[Mapping[str, Any], ...]
    error: str = ""
    """Why it was not done; empty: done."""


@dataclass(frozen=True, slots=True)
class ArbiterSeen:
    """The line arbiter was lost, or is back."""

    at: int
    there: bool
    why: str = ""


@dataclass(frozen=True, slots=True)
class Published:
    """A status as the world gets it, with what the program knows beside its automata; in no recording."""

    at: int
    status: Status
    refused: Mapping[str, str]
    """Sentences by command, of those that do not come to the automata now: no lines, no arbiter, maintenance."""


INPUTS: Mapping[str, type] = {
    "start": Start,
    "frame": FrameTaken,
    "command": Commanded,
    "tell": PeerUpdate,
    "refused": ActivationRefused,
    "acknowledge": Acknowledged,
    "time": TimeAdvanced,
}
"""What a replay feeds to the controller."""
OBSERVED: Mapping[str, type] = {"begin": Begun, "write": Written, "event": Received, "step": Step}
"""What the automata saw and did: what the monitor judges."""
DECIDED: Mapping[str, type] = {**OBSERVED, "answer": Answered, "status": Status}
"""What a replay must decide the same."""
STATE = "state"
"""Where the controller stands: with it each segment but the first begins."""
KINDS: Mapping[str, type] = {
    "header": Header,
    STATE: ControllerSnapshot,
    **INPUTS,
    **DECIDED,
    "lines": LinesWritten,
    "arbiter": ArbiterSeen,
}
PUBLISHED = "published"
STREAMED: Mapping[str, type] = {**KINDS, PUBLISHED: Published}
"""What the stream of a program has."""
