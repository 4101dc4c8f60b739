"""What an end-effector is made of: YAML in, frozen typed objects out; pure."""

from end_effector_hal.kinds.stanza import (
    NO_CHANNEL,
    Actuator,
    ChangerEndings,
    Endings,
    GrippingEndings,
    HeldEndings,
    Hold,
    OwnEndings,
    OwnGrippingEndings,
    OwnHeldEndings,
    Part,
    ProgramEnding,
    Supply,
)

from ._codec_channels import CodecChannels
from ._codec_match import unproven
from ._devices import EStop, Lines, Link, ToolChanger
from ._examine import Examination, examine, examine_text
from ._fault import CODES, Fault, did_you_mean
from ._load import load
from ._markdown import markdown
from ._model import Description, camel_case
from ._not_fitted import not_fitted
from ._paths import profile_path, run_directory, tool_path
from ._policy import Automata, Bounds, Interlocks, MaintenanceSettings
from ._schema import schema, schema_path, schema_text
from ._slow import slow
from ._socket import socket_path
from ._uses import used_channels

__all__ = [
    "CODES",
    "NO_CHANNEL",
    "Actuator",
    "Automata",
    "Bounds",
    "ChangerEndings",
    "CodecChannels",
    "Description",
    "EStop",
    "Endings",
    "Examination",
    "Fault",
    "GrippingEndings",
    "HeldEndings",
    "Hold",
    "Interlocks",
    "Lines",
    "Link",
    "MaintenanceSettings",
    "OwnEndings",
    "OwnGrippingEndings",
    "OwnHeldEndings",
    "Part",
    "ProgramEnding",
    "Supply",
    "ToolChanger",
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
