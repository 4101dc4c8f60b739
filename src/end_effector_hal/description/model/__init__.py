"""What an end-effector is made of: frozen, typed stanzas."""

from ._channels import (
    Channel,
    DigitalInput,
    Inputs,
    LinkFrame,
    ModbusFrame,
    RecordFrame,
    RecordValue,
    RegisterValue,
    TextFrame,
    TextValue,
)
from ._description import Description, camel_case, socket_path
from ._stanzas import EStop, Freshness, Link, ToolChanger

__all__ = [
    "Channel",
    "Description",
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
    "socket_path",
]
