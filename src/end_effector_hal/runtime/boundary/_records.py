"""The records of a trace; all times are µs on the monotonic clock.

They are the inputs of the controller, its outputs, and the observations of its automata.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from end_effector_hal.control import ControllerSnapshot, Status
from end_effector_hal.recording import Gap
from end_effector_hal.runtime.stream import HEALTH, PUBLISHED, READINGS, Entry
from end_effector_hal.sensing import JudgedReadings
from end_effector_hal.signals import Frame
from end_effector_hal.wires.sensors import SensorHealth
from timed_automata import Begun, Received, Step, Written


@dataclass(frozen=True, slots=True)
class Header:
    """The first record of each segment, with the origin of the trace."""

    at: int
    description: str
    """Name of the tool."""
    hash: str
    """Hash of the description and its automata, as in run.json."""
    model: str
    """Hash of the UPPAAL file."""
    version: str
    started: str
    """Time of the start, ISO 8601."""
    source: str
    """Path of the description file."""
    constants: Mapping[str, Any]
    """Constants of the description that were inserted into the model."""
    run: str
    """Random id; the same in all segments of one start of the program."""
    segment: int = 1
    """Number of the segment since that start."""
    follows: bool = False
    """Whether the previous segment was closed in good order, and nothing is missing between the two."""
    gap: Gap | None = None
    """The records that are missing before this segment; None: none."""


@dataclass(frozen=True, slots=True)
class Start:
    """The start of a controller, with the levels of the lines as they were found."""

    at: int
    levels: Mapping[str, bool]
    sensor_fault: bool = False
    """Whether a sensor fault of the tool changer was latched before."""
    grip_error: bool = False
    """Whether GRIP_ERROR was latched before the program restarted by itself."""
    part: str = ""
    """Name of the part that is held by the record of the line arbiter; empty: there is no record."""


@dataclass(frozen=True, slots=True)
class FrameTaken:
    """A frame that arrived at ``stamp`` and was processed at ``at``; values: gauge Pa or bits, null if invalid."""

    at: int
    stamp: int
    seq: int | None
    device_ms: int | None
    values: Mapping[str, int | bool | None]
    inactive: tuple[str, ...] = ()
    """The outputs of a commanded bus that were known to be inactive before these values were requested."""

    @classmethod
    def of(cls, frame: Frame, at: int) -> FrameTaken:
        """Return the record of a frame that is processed at ``at`` µs."""
        return cls(at, frame.at, frame.seq, frame.device_ms, frame.values, frame.inactive)

    @property
    def frame(self) -> Frame:
        """The frame."""
        return Frame(self.stamp, self.seq, self.device_ms, self.values, self.inactive)


@dataclass(frozen=True, slots=True)
class Commanded:
    """A command, given by the name of its channel."""

    at: int
    name: str
    part: str = ""
    """Name of the part that is to be gripped; empty: the default one."""


@dataclass(frozen=True, slots=True)
class ActivationRefused:
    """The line arbiter refused an activation that the last status requested."""

    at: int
    unlock: bool = False
    """Whether it is the unlock output."""


@dataclass(frozen=True, slots=True)
class Acknowledged:
    """A person has seen the alarms that are over."""

    at: int


@dataclass(frozen=True, slots=True)
class TimeAdvanced:
    """Time has passed until ``at``."""

    at: int


@dataclass(frozen=True, slots=True)
class Answered:
    """The answer to the command before it."""

    at: int
    accepted: bool
    reason: str


@dataclass(frozen=True, slots=True)
class LinesWritten:
    """Levels and the last will that were sent to the line arbiter at ``at``, and how long that took."""

    at: int
    took_us: int
    levels: Mapping[str, bool]
    will: tuple[Mapping[str, Any], ...]
    error: str = ""
    """Why the write failed; empty: it succeeded."""


@dataclass(frozen=True, slots=True)
class ArbiterSeen:
    """The line arbiter was lost, or is back."""

    at: int
    there: bool
    why: str = ""


@dataclass(frozen=True, slots=True)
class Published:
    """A status as clients get it, with the additions of the program; it is in no recording."""

    at: int
    status: Status
    refused: Mapping[str, str]
    """Sentences by command, for commands that do not reach the automata now: no lines, no arbiter, or maintenance."""


INPUTS: Mapping[str, type] = {
    "start": Start,
    "frame": FrameTaken,
    "command": Commanded,
    "refused": ActivationRefused,
    "acknowledge": Acknowledged,
    "time": TimeAdvanced,
}
"""Records that a replay feeds to the controller."""
OBSERVED: Mapping[str, type] = {"begin": Begun, "write": Written, "event": Received, "step": Step}
"""Observations of the automata, which the monitor judges."""
DECIDED: Mapping[str, type] = {**OBSERVED, "answer": Answered, "status": Status}
"""Records in which a replay must agree with the recording."""
STATE = "state"
"""Kind of the record with the state of the controller; every segment but the first begins with it."""
KINDS: Mapping[str, type] = {
    "header": Header,
    STATE: ControllerSnapshot,
    **INPUTS,
    **DECIDED,
    "lines": LinesWritten,
    "arbiter": ArbiterSeen,
}
STREAMED: Mapping[str, type] = {**KINDS, PUBLISHED: Published, READINGS: JudgedReadings, HEALTH: SensorHealth}
"""Kinds of records in the stream of a program."""
_KIND_OF = {type_: kind for kind, type_ in STREAMED.items()}


def entry_of(record: Any) -> Entry:
    """Return a record with its kind and its time."""
    return _KIND_OF[type(record)], record.at, record
