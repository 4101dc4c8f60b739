"""The table of the ROS surface: every topic, service, action and parameter, named once.

Names are relative, so that a namespace or a remap works. Types are ``package/Name``, as in ROS 1.
"""

from __future__ import annotations

from dataclasses import dataclass

from end_effector_hal.description import Description, camel_case
from end_effector_hal.kinds import kind_of
from end_effector_hal.vocabulary import Command

HAL_MAIN, GRIP, TOOL_CHANGE = "HALMain", "Grip", "ToolChange"
PRESSURE, POSITION = "Pressure", "Position"
SUPERVISOR, DATA_LOGGER = "Supervisor", "DataLogger"
HAL_NODES = (HAL_MAIN, GRIP, TOOL_CHANGE, PRESSURE, POSITION)
NODES = (*HAL_NODES, SUPERVISOR, DATA_LOGGER, "LineOwner")
OF_ROS = ("rosout", "rosout_agg", "clock")
"""Global topics of ROS itself."""

STATE_HZ, DIAGNOSTICS_HZ = 10.0, 1.0
GONE_AFTER_S = 1.0
"""A periodic internal state that is silent for longer: its node has gone."""


@dataclass(frozen=True, slots=True)
class Topic:
    """A topic: who publishes it, when, and how.

    Attributes:
        name: relative (``/diagnostics`` is global by REP-107).
        type: of its messages.
        publishers: nodes of this package. To them nothing counts that another node publishes here.
        subscribers: nodes of this package; others are free to subscribe.
        on: what it is published on: ``change``, ``frame`` or ``command``; empty: only periodically.
        rate_hz: periodic besides, None: not.
        latched: a new subscriber gets the last message at once (ROS 2: transient local, depth 1).
        queue: messages kept for a slow subscriber; the oldest is dropped.
        internal: between nodes of this package, may change.
        public: messages of any node count.
    """

    name: str
    type: str
    publishers: tuple[str, ...]
    subscribers: tuple[str, ...] = ()
    on: str = "change"
    rate_hz: float | None = None
    latched: bool = False
    queue: int = 10
    internal: bool = False
    public: bool = False


@dataclass(frozen=True, slots=True)
class Service:
    """A service, the node that serves it, and the nodes of this package that may call it; empty: anybody may."""

    name: str
    type: str
    server: str
    callers: tuple[str, ...] = ()

    @property
    def internal(self) -> bool:
        """Between nodes of this package, may change."""
        return bool(self.callers)


@dataclass(frozen=True, slots=True)
class Action:
    """An action, its server, and the command of Table II that a goal gives."""

    name: str
    type: str
    server: str
    command: Command


@dataclass(frozen=True, slots=True)
class Parameter:
    """A private parameter (``~name``): a string."""

    name: str
    nodes: tuple[str, ...]
    about: str


def _pressure(name: str) -> Topic:
    return Topic(name, "sensor_msgs/FluidPressure", (PRESSURE,), (HAL_MAIN,), on="frame", queue=10)


# A second of changes is kept: nothing of a run is lost when a subscriber stumbles.
SENSOR_FRAME = Topic(
    "sensor_frame", "end_effector_msgs/SensorFrame", (PRESSURE,), (GRIP, TOOL_CHANGE, POSITION, DATA_LOGGER),
    on="frame", queue=50, internal=True,
)  # fmt: skip
GRIP_STATE = Topic(
    "grip/state", "end_effector_msgs/UnitStatus", (GRIP,), (TOOL_CHANGE, HAL_MAIN),
    rate_hz=STATE_HZ, latched=True, queue=100, internal=True,
)  # fmt: skip
TOOL_CHANGE_STATE = Topic(
    "tool_change/state", "end_effector_msgs/UnitStatus", (TOOL_CHANGE,), (GRIP, HAL_MAIN),
    rate_hz=STATE_HZ, latched=True, queue=100, internal=True,
)  # fmt: skip
POSITION_TOOL_CHANGER = Topic(
    "PositionToolChanger", "end_effector_msgs/ToolChangerPosition", (POSITION,), (HAL_MAIN,),
    rate_hz=STATE_HZ, latched=True,
)  # fmt: skip
POSITION_TOOL_STAND = Topic(
    "PositionToolStand", "end_effector_msgs/ToolStandPosition", (POSITION,), (HAL_MAIN,),
    rate_hz=STATE_HZ, latched=True,
)  # fmt: skip
END_EFFECTOR_STATE = Topic(
    "EndEffectorState", "end_effector_msgs/EndEffectorState", (HAL_MAIN,), (DATA_LOGGER, SUPERVISOR),
    rate_hz=STATE_HZ, latched=True, queue=100,
)  # fmt: skip
SUPERVISOR_COMMANDS = Topic(
    "supervisor_commands", "end_effector_msgs/SupervisorCommand", (SUPERVISOR,), (DATA_LOGGER,), on="command",
    queue=100, public=True,
)  # fmt: skip
DIAGNOSTICS = Topic(
    "/diagnostics", "diagnostic_msgs/DiagnosticArray", (*HAL_NODES, DATA_LOGGER),
    on="", rate_hz=DIAGNOSTICS_HZ, queue=10,
)  # fmt: skip

GRIP_COMMAND = Service("grip/command", "end_effector_msgs/HalCommand", GRIP, (HAL_MAIN,))
TOOL_CHANGE_COMMAND = Service(
    "tool_change/command", "end_effector_msgs/HalCommand", TOOL_CHANGE, (HAL_MAIN, GRIP)
)

PRESSURE_SUPPLY = _pressure("PressureSupply")
FIXED_TOPICS = (
    END_EFFECTOR_STATE, SUPERVISOR_COMMANDS, SENSOR_FRAME, GRIP_STATE, TOOL_CHANGE_STATE, DIAGNOSTICS,
    POSITION_TOOL_CHANGER, POSITION_TOOL_STAND, PRESSURE_SUPPLY,
)  # fmt: skip
"""Topics that are called the same for every tool."""

ARM_TOOL_CHANGER = Service("ArmToolChanger", "std_srvs/Trigger", TOOL_CHANGE)
RESET = 100
"""A command of the internal services besides those of Table II."""
RESET_FAULTS = Service("ResetFaults", "std_srvs/Trigger", GRIP)
FIXED_SERVICES = (ARM_TOOL_CHANGER, RESET_FAULTS, GRIP_COMMAND, TOOL_CHANGE_COMMAND)
"""Services that are called the same for every tool."""

LOCK_TOOL_CHANGER = Action("LockToolChanger", "end_effector_msgs/EndEffector", HAL_MAIN, Command.LOCK)
UNLOCK_TOOL_CHANGER = Action("UnlockToolChanger", "end_effector_msgs/EndEffector", HAL_MAIN, Command.UNLOCK)
TRIGGER_GRIP = Action("TriggerGrip", "end_effector_msgs/EndEffector", HAL_MAIN, Command.GRIP)
DROP = Action("Drop", "end_effector_msgs/EndEffector", HAL_MAIN, Command.RELEASE)
ACTIONS = (LOCK_TOOL_CHANGER, UNLOCK_TOOL_CHANGER, TRIGGER_GRIP, DROP)

DESCRIPTION = Parameter(
    "description",
    (*HAL_NODES, DATA_LOGGER),
    "path of the YAML file, never its content; required, or a profile",
)
PROFILE = Parameter("profile", DESCRIPTION.nodes, "name of a shipped tool, instead of a description")
SCRIPT = Parameter("script", (SUPERVISOR,), "commands to give, such as `lock; grip; wait 2; release; quit`")
DIRECTORY = Parameter(
    "directory",
    (DATA_LOGGER, GRIP, TOOL_CHANGE),
    "run folder that it writes; Grip, ToolChange: empty, no trace",
)
PATIENCE = Parameter(
    "patience", (SUPERVISOR,), "seconds; a goal is given up when HALMain is silent for longer"
)
SEGMENT_MB = Parameter(
    "segment_mb",
    (DATA_LOGGER, GRIP, TOOL_CHANGE),
    "files of a recording are cut into such segments, MB; default: 64",
)
KEEP_MB = Parameter(
    "keep_mb",
    (DATA_LOGGER, GRIP, TOOL_CHANGE),
    "the folder keeps so much, MB, the oldest segments are removed; default: 1000",
)
PARAMETERS = (DESCRIPTION, PROFILE, SCRIPT, DIRECTORY, PATIENCE, SEGMENT_MB, KEEP_MB)


def pressure_topic(description: Description, actuator: str) -> Topic:
    """The absolute pressure of an actuator; raises KeyError for an unknown one."""
    return _pressure(description.topic_of(actuator))


def pressure_topics(description: Description) -> tuple[tuple[str, Topic], ...]:
    """Channel of the link and its topic: the actuators in sequence order, then the supply."""
    own = ((part.channel, pressure_topic(description, name)) for name, part in description.ordered)
    return (*own, (description.supply.channel, PRESSURE_SUPPLY))


def position_topics(description: Description) -> dict[str, Topic]:
    """What moves between two end positions, to the topic of its position."""
    return {
        name: Topic(
            "Position" + camel_case(name), "end_effector_msgs/CylinderPosition", (POSITION,), (HAL_MAIN,),
            rate_hz=STATE_HZ, latched=True,
        )
        for name, part in description.ordered
        if kind_of(part).moves
    }  # fmt: skip


def set_services(description: Description) -> dict[str, Service]:
    """Actuator to its ``/Set*`` service."""
    return {name: _set(description.service_of(name), GRIP) for name in description.sequence}


def set_tool_changer(description: Description) -> Service | None:
    """The service of the tool changer, if one is fitted."""
    return _set(description.tool_changer.service, TOOL_CHANGE) if description.tool_changer else None


def topics(description: Description) -> tuple[Topic, ...]:
    """Every topic of a tool."""
    changer = (POSITION_TOOL_CHANGER, POSITION_TOOL_STAND) if description.tool_changer else ()
    return (
        END_EFFECTOR_STATE, SUPERVISOR_COMMANDS, *(topic for _, topic in pressure_topics(description)),
        *position_topics(description).values(), *changer,
        SENSOR_FRAME, GRIP_STATE, TOOL_CHANGE_STATE, DIAGNOSTICS,
    )  # fmt: skip


def services(description: Description) -> tuple[Service, ...]:
    """Every service of a tool."""
    changer = set_tool_changer(description)
    own = (*set_services(description).values(), *((changer, ARM_TOOL_CHANGER) if changer else ()))
    return (*own, RESET_FAULTS, GRIP_COMMAND, TOOL_CHANGE_COMMAND)


def _set(name: str, server: str) -> Service:
    return Service(name, "std_srvs/SetBool", server)
