"""The messages that the nodes publish, with the field names of ``end_effector_msgs``, and how a generation of ROS finds
the classes that it has generated from their definitions.

A transport converts the messages. Received ones have the same fields, in the class of the ROS generation. Times in µs
are of the monotonic clock of this machine.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec
from math import nan
from typing import Any

from end_effector_hal.control import Answer
from end_effector_hal.errors import RosError


@dataclass(slots=True)
class MessageHeader:
    """The time of the content of a message, µs; None: that of publishing. The transport converts it to ROS time."""

    at_us: int | None = None
    frame_id: str = ""


AMBIENT_PA = 101_325
"""The standard atmosphere, Pa: a FluidPressure is absolute, a reading is gauge."""


@dataclass(slots=True)
class PressureMessage:
    """The message ``FluidPressure``: absolute, in Pa; NaN: unknown."""

    fluid_pressure: float
    header: MessageHeader


@dataclass(slots=True)
class PositionMessage:
    """The message ``ToolChangerPosition`` or ``ToolStandPosition``: an integer, 0 is UNKNOWN, and its name."""

    position: int
    position_name: str
    header: MessageHeader


@dataclass(slots=True)
class CylinderPositionMessage:
    """The message ``CylinderPosition``, also with the fraction of the stroke; NaN: unknown."""

    position: int
    position_name: str
    fraction: float
    header: MessageHeader


@dataclass(slots=True)
class JointStateMessage:
    """The message ``JointState``, with only the joints whose position is proven, m or rad."""

    name: Sequence[str]
    position: Sequence[float]
    header: MessageHeader = field(default_factory=MessageHeader)


@dataclass(slots=True)
class CommandMessage:
    """The message ``SupervisorCommand``: an integer of Table II, and the part that a grip is for."""

    command: int
    command_name: str
    part: str = ""
    header: MessageHeader = field(default_factory=MessageHeader)


@dataclass(slots=True)
class StepMessage:
    """The message ``StepReport``."""

    actuator: str
    attempts: int
    seconds: float
    confirmed: bool


@dataclass(slots=True)
class EventMessage:
    """``ToolEvent``."""

    at_us: int
    event: str
    actuator: str = ""
    attempt: int = 0
    old_state: int = -1
    new_state: int = -1
    cause: int = 0
    command: str = ""


@dataclass(slots=True)
class StateMessage:
    """The message ``EndEffectorState``: the aggregated state."""

    since_us: int
    count: int
    at_us: int
    tool: str
    state: int
    state_name: str
    command: int
    command_name: str
    actuator_names: Sequence[str]
    actuator_kinds: Sequence[str]
    actuators: Sequence[int]
    actuator_states: Sequence[str]
    outputs: Sequence[bool]
    evidence: Sequence[int]
    evidence_names: Sequence[str]
    margins: Sequence[float]
    margin_units: Sequence[str]
    positions: Sequence[float]
    actuator: str
    attempt: int
    attempts_allowed: int
    time_left_s: float
    steps: Sequence[StepMessage]
    cause: int
    cause_name: str
    cause_actuator: str
    reason: str
    held: bool
    part: str
    lift_allowed: bool
    secure: bool
    maintenance: bool
    tool_changer: int
    tool_changer_name: str
    unlock_output: bool
    tool_position: int
    tool_position_name: str
    tool_stand: int
    tool_stand_name: str
    link_up: bool
    stale: Sequence[str]
    missed: int
    worst_late_us: int
    alarms: Sequence[str]
    alarm_ids: Sequence[str]
    events: Sequence[EventMessage] = ()
    header: MessageHeader = field(default_factory=MessageHeader)


@dataclass(slots=True)
class GoalMessage:
    """The message ``EndEffector_Goal``: the part that a grip is for; empty: the default one."""

    part: str = ""


@dataclass(slots=True)
class FeedbackMessage:
    """The message ``EndEffector_Feedback``."""

    state: int
    state_name: str
    actuator: str
    attempt: int
    attempts_allowed: int
    time_left_s: float


@dataclass(slots=True)
class ResultMessage:
    """The message ``EndEffector_Result``."""

    outcome: int
    outcome_name: str
    state: int
    state_name: str
    reason: str
    seconds: float = 0.0
    steps: Sequence[StepMessage] = ()


@dataclass(slots=True)
class GripperMessage:
    """The messages ``GripperCommand_Result`` and ``_Feedback``; NaN: unknown."""

    position: float
    effort: float = nan
    stalled: bool = False
    reached_goal: bool = False


@dataclass(slots=True)
class ParallelGripperMessage:
    """The messages ``ParallelGripperCommand_Result`` and ``_Feedback``."""

    state: JointStateMessage
    stalled: bool = False
    reached_goal: bool = False


@dataclass(slots=True)
class KeyValueMessage:
    """The message ``diagnostic_msgs/KeyValue``."""

    key: str
    value: str


@dataclass(slots=True)
class DiagnosticMessage:
    """The message ``diagnostic_msgs/DiagnosticStatus``."""

    level: int
    name: str
    message: str
    hardware_id: str
    values: Sequence[KeyValueMessage]


@dataclass(slots=True)
class DiagnosticsMessage:
    """The message ``diagnostic_msgs/DiagnosticArray``."""

    status: Sequence[DiagnosticMessage]
    header: MessageHeader = field(default_factory=MessageHeader)


RESPONSE_FIELDS = {"success": "accepted", "message": "reason"}
"""Fields of ``std_srvs`` that have another name in :class:`Answer`."""


def answer_of(response: Any) -> Answer:
    """Return the answer in a response of ``std_srvs``."""
    return Answer(response.success, response.message)


def has_ros_class(name: str, kind: str) -> bool:
    """Return whether a type is installed, named as for `ros_class`."""
    package, _, plain = name.partition("/")
    if find_spec(package) is None or find_spec(f"{package}.{kind}") is None:
        return False
    return hasattr(importlib.import_module(f"{package}.{kind}"), plain)


def ros_class(name: str, kind: str, todo: str) -> Any:
    """Return a generated class.

    Args:
        name: name of the type, such as ``std_msgs/Header``.
        kind: ``msg``, ``srv`` or ``action``.
        todo: how types are built in this generation.

    Raises:
        RosError: the type is not built.
        ModuleNotFoundError: a package that it needs is not installed.
    """
    package, _, plain = name.partition("/")
    try:
        return getattr(importlib.import_module(f"{package}.{kind}"), plain)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != package or error.name == package:
            raise
        raise RosError(f"The ROS type {name} is not there.", todo=todo) from None
    except (ImportError, AttributeError):
        raise RosError(f"The ROS type {name} is not there.", todo=todo) from None
