"""What an end-effector is made of: YAML in, frozen typed objects out; pure.

``model`` has the stanzas, ``reading`` leads from a file to them, ``rules`` says what cannot be meant.
"""

from ._fault import CODES, Fault, did_you_mean
from ._paths import profile_names, profile_path, run_directory, tool_path
from ._reference import markdown, schema, schema_path, schema_text
from .model import (
    PASCAL,
    Channel,
    Description,
    DeviceAlarm,
    DigitalInput,
    EStop,
    Freshness,
    Inputs,
    Link,
    ModbusFrame,
    RecordFrame,
    RecordValue,
    RegisterValue,
    TextFrame,
    TextValue,
    ToolChanger,
    camel_case,
    mask_shift,
    raw_limits,
    socket_path,
    type_bits,
)
from .reading import examine, examine_text, load
from .rules import CodecChannels, lost_by_silence, not_fitted, slow, unproven, used_channels

__all__ = [
    "CODES",
    "PASCAL",
    "Channel",
    "CodecChannels",
    "Description",
    "DeviceAlarm",
    "DigitalInput",
    "EStop",
    "Fault",
    "Freshness",
    "Inputs",
    "Link",
    "ModbusFrame",
    "RecordFrame",
    "RecordValue",
    "RegisterValue",
    "TextFrame",
    "TextValue",
    "ToolChanger",
    "camel_case",
    "did_you_mean",
    "examine",
    "examine_text",
    "load",
    "lost_by_silence",
    "markdown",
    "mask_shift",
    "not_fitted",
    "profile_names",
    "profile_path",
    "raw_limits",
    "run_directory",
    "schema",
    "schema_path",
    "schema_text",
    "slow",
    "socket_path",
    "tool_path",
    "type_bits",
    "unproven",
    "used_channels",
]
