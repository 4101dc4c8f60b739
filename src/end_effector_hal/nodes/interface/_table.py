"""The table of the ROS interface, which defines every topic, service, action and parameter once.

Names are relative, so that a namespace or a remap works. Types are ``package/Name``, in ROS 1 and ROS 2 alike.
"""

from __future__ import annotations

from dataclasses import dataclass

from end_effector_hal.vocabulary import Command


@dataclass(frozen=True, slots=True)
class Topic:
    """A topic: its publishers, and when and how they publish.

    Attributes:
        name: relative (``/diagnostics`` is global by REP-107).
        type: type of its messages.
        publishers: nodes of this package.
        subscribers: nodes of this package; others are free to subscribe.
        on: the cause of a message: ``change``, ``frame`` or ``command``; empty: only the clock.
        rate_hz: rate of additional periodic messages; None: there are none.
        latched: whether a new subscriber gets the last message at once (ROS 2: transient local, depth 1).
        queue: number of messages kept for a slow subscriber; beyond it the oldest is dropped.
    """

    name: str
    type: str
    publishers: tuple[str, ...]
    subscribers: tuple[str, ...] = ()
    on: str = "change"
    rate_hz: float | None = None
    latched: bool = False
    queue: int = 10


@dataclass(frozen=True, slots=True)
class Service:
    """A service, and the node that serves it."""

    name: str
    type: str
    server: str


@dataclass(frozen=True, slots=True)
class Action:
    """An action and its server.

    Attributes:
        name: relative.
        type: type of its goals, results and feedback.
        server: the node that serves it.
        generations: generations of ROS that offer it.
        optional: whether it is only offered if the package of its type is installed.
    """

    name: str
    type: str
    server: str
    generations: tuple[int, ...] = (1, 2)
    optional: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandAction(Action):
    """An action whose goals all give the same command of Table II."""

    command: Command


@dataclass(frozen=True, slots=True)
class Parameter:
    """A private parameter (``~name``) with a string as its value."""

    name: str
    nodes: tuple[str, ...]
    about: str


HAL_MAIN, GRIP, TOOL_CHANGE = "HALMain", "Grip", "ToolChange"
PRESSURE, POSITION = "Pressure", "Position"
SUPERVISOR, DATA_LOGGER = "Supervisor", "DataLogger"
MANAGER = "EndEffector"
"""The managed node of ROS 2; while it is active, the nodes of the HAL work."""
HAL_NODES = (HAL_MAIN, GRIP, TOOL_CHANGE, PRESSURE, POSITION)
NODES = (*HAL_NODES, SUPERVISOR, DATA_LOGGER, "LineArbiter")
OF_ROS = ("rosout", "rosout_agg", "clock")
"""Global topics of ROS itself."""

STATE_HZ, DIAGNOSTICS_HZ = 10.0, 1.0
GIVE_UP_S = 30.0
"""Longest wait of a client for the actions, s."""
PATIENCE_S = 10.0
"""Longest wait of a client for a silent HALMain, s; it is back 2 to 3 s after it was killed, later on a
busy machine.
"""


def pressure(name: str) -> Topic:
    """Return the topic of a pressure with that name."""
    return Topic(name, "sensor_msgs/FluidPressure", (PRESSURE,), on="frame")


POSITION_TOOL_CHANGER = Topic(
    "PositionToolChanger", "end_effector_msgs/ToolChangerPosition", (POSITION,), rate_hz=STATE_HZ, latched=True
)  # fmt: skip
POSITION_TOOL_STAND = Topic(
    "PositionToolStand", "end_effector_msgs/ToolStandPosition", (POSITION,), rate_hz=STATE_HZ, latched=True
)  # fmt: skip
JOINT_STATES = Topic("joint_states", "sensor_msgs/JointState", (POSITION,), rate_hz=STATE_HZ)
# A queue of 100 keeps a second of changes: nothing of a run is lost when a subscriber stumbles.
END_EFFECTOR_STATE = Topic(
    "EndEffectorState", "end_effector_msgs/EndEffectorState", (HAL_MAIN,), (DATA_LOGGER, SUPERVISOR),
    rate_hz=STATE_HZ, latched=True, queue=100,
)  # fmt: skip
SUPERVISOR_COMMANDS = Topic(
    "supervisor_commands", "end_effector_msgs/SupervisorCommand", (SUPERVISOR,), (DATA_LOGGER,), on="command",
    queue=100,
)  # fmt: skip
DIAGNOSTICS = Topic(
    "/diagnostics", "diagnostic_msgs/DiagnosticArray", (*HAL_NODES, DATA_LOGGER),
    on="", rate_hz=DIAGNOSTICS_HZ, queue=10,
)  # fmt: skip

PRESSURE_SUPPLY = pressure("PressureSupply")
FIXED_TOPICS = (
    END_EFFECTOR_STATE, SUPERVISOR_COMMANDS, DIAGNOSTICS,
    POSITION_TOOL_CHANGER, POSITION_TOOL_STAND, PRESSURE_SUPPLY, JOINT_STATES,
)  # fmt: skip
"""Topics with the same name for every tool."""

ARM_TOOL_CHANGER = Service("ArmToolChanger", "std_srvs/Trigger", TOOL_CHANGE)
RESET_FAULTS = Service("ResetFaults", "std_srvs/Trigger", GRIP)
RESUME_GRIP = Service("ResumeGrip", "std_srvs/Trigger", GRIP)
STOP_TOOL = Service("StopTool", "std_srvs/Trigger", GRIP)
FIXED_SERVICES = (ARM_TOOL_CHANGER, RESUME_GRIP, STOP_TOOL, RESET_FAULTS)
"""Services with the same name for every tool."""


def command_action(name: str, command: Command) -> CommandAction:
    """Return an action of this package's own type."""
    return CommandAction(name, "end_effector_msgs/EndEffector", HAL_MAIN, command=command)


LOCK_TOOL_CHANGER = command_action("LockToolChanger", Command.LOCK)
UNLOCK_TOOL_CHANGER = command_action("UnlockToolChanger", Command.UNLOCK)
TRIGGER_GRIP = command_action("TriggerGrip", Command.GRIP)
DROP = command_action("Drop", Command.RELEASE)
COMMAND_ACTIONS = (LOCK_TOOL_CHANGER, UNLOCK_TOOL_CHANGER, TRIGGER_GRIP, DROP)

# MoveIt's name of an action is that of its controller, then action_ns
GRIPPER_COMMAND = Action(
    "gripper_controller/gripper_cmd", "control_msgs/GripperCommand", HAL_MAIN,
    generations=(2,), optional=True,
)  # fmt: skip
PARALLEL_GRIPPER_COMMAND = Action(
    "parallel_gripper_controller/gripper_cmd", "control_msgs/ParallelGripperCommand", HAL_MAIN,
    generations=(2,), optional=True,
)  # fmt: skip
ACTIONS: tuple[Action, ...] = (*COMMAND_ACTIONS, GRIPPER_COMMAND, PARALLEL_GRIPPER_COMMAND)

DESCRIPTION = Parameter(
    "description",
    (*HAL_NODES, DATA_LOGGER, MANAGER),
    "path of the YAML file, never its content; required, or a profile",
)
PROFILE = Parameter("profile", DESCRIPTION.nodes, "name of a shipped tool, instead of a description")
CONNECT = Parameter(
    "connect",
    (HAL_MAIN, MANAGER),
    "`true`: use the tool that `eehal serve` runs, which outlives a restart of ROS; default: HALMain runs it",
)
SCRIPT = Parameter("script", (SUPERVISOR,), "commands to give, such as `lock; grip; wait 2; drop; quit`")
DIRECTORY = Parameter(
    "directory",
    (DATA_LOGGER, HAL_MAIN, MANAGER),
    "run folder to write; if it is empty, HALMain writes no trace",
)
FRAME_ID = Parameter(
    "frame_id",
    (PRESSURE, MANAGER),
    "frame of the pressures; default: TOOL_link, as `eehal export urdf` calls it",
)
SEGMENT_MB = Parameter(
    "segment_mb",
    (DATA_LOGGER, HAL_MAIN, MANAGER),
    "size at which a recorded file is closed and the next segment begins, MB; default: 64",
)
KEEP_MB = Parameter(
    "keep_mb",
    (DATA_LOGGER, HAL_MAIN, MANAGER),
    "largest size of the folder, MB; the oldest segments are removed; default: 1000",
)
PROVE = Parameter("prove", (MANAGER,), "`true`: prove the tool when it is configured and no verdict is kept")
READY_S = Parameter("ready_s", (MANAGER,), "seconds; how long activate waits for the sensors; default: 10")
PARAMETERS = (
    DESCRIPTION,
    PROFILE,
    CONNECT,
    SCRIPT,
    DIRECTORY,
    FRAME_ID,
    SEGMENT_MB,
    KEEP_MB,
    PROVE,
    READY_S,
)
