"""What an end-effector is made of: YAML in, frozen typed objects out; pure."""

from ._actuators import Actuator, ActuatorPart, BlowOff, CylinderActuator, VacuumActuator
from ._carried import Carried
from ._devices import EStop, Lines, Link, Supply, ToolChanger
from ._endings import (
    ChangerEndings,
    Endings,
    GrippingEndings,
    HeldEndings,
    OwnEndings,
    OwnGrippingEndings,
    OwnHeldEndings,
    ProgramEnding,
)
from ._examine import Examination, examine, examine_text
from ._fault import CODES, Fault, did_you_mean
from ._fitting import unproven
from ._load import load
from ._markdown import markdown
from ._model import Description, camel_case
from ._part import NO_CHANNEL, Part
from ._paths import profile_path, run_directory, tool_path
from ._policy import Automata, Bounds, Handwork, Hold, Interlocks
from ._schema import schema, schema_path, schema_text
from ._slow import slow
from ._socket import socket_path
from ._unfitted import not_fitted
from ._uses import used_channels

__all__ = [
    "CODES",
    "NO_CHANNEL",
    "Actuator",
    "ActuatorPart",
    "Automata",
    "BlowOff",
    "Bounds",
    "Carried",
    "ChangerEndings",
    "CylinderActuator",
    "Description",
    "EStop",
    "Endings",
    "Examination",
    "Fault",
    "GrippingEndings",
    "Handwork",
    "HeldEndings",
    "Hold",
    "Interlocks",
    "Lines",
    "Link",
    "OwnEndings",
    "OwnGrippingEndings",
    "OwnHeldEndings",
    "Part",
    "ProgramEnding",
    "Supply",
    "ToolChanger",
    "VacuumActuator",
    "camel_case",
    "did_you_mean",
    "examine",
    "examine_text",
    "load",
    "markdown",
    "not_fitted",
    "profile_path",
    "run_directory",
    "schema",
    "schema_path",
    "schema_text",
    "slow",
    "socket_path",
    "tool_path",
    "unproven",
    "used_channels",
]
