"""The frozen, typed stanzas of a description."""

from ._channels import (
    COUNTS,
    HEXADECIMAL,
    PASCAL,
    QUANTITIES,
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
from ._stanzas import EStop, Freshness, Link, PlainOutput, ToolChanger
