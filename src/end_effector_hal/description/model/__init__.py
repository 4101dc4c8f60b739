"""What an end-effector is made of: frozen, typed stanzas."""

from ._channels import (
    HEXADECIMAL,
    PASCAL,
    Channel,
    DeviceAlarm,
    DigitalInput,
    Inputs,
    LinkFrame,
    ModbusFrame,
    RecordFrame,
    RecordValue,
    RegisterValue,
    TextFrame,
    TextValue,
    mask_shift,
    raw_limits,
    type_bits,
)
from ._description import Description, camel_case, socket_path
from ._stanzas import EStop, Freshness, Link, ToolChanger

__all__ = [
    "HEXADECIMAL",
    "PASCAL",
    "Channel",
    "Description",
    "DeviceAlarm",
    "DigitalInput",
    "EStop",
    "Freshness",
    "Inputs",
    "Link",
    "LinkFrame",
    "ModbusFrame",
    "RecordFrame",
    "RecordValue",
    "RegisterValue",
    "TextFrame",
    "TextValue",
    "ToolChanger",
    "camel_case",
    "mask_shift",
    "raw_limits",
    "socket_path",
    "type_bits",
]
