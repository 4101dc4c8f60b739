"""The description of an end-effector: YAML in, frozen typed objects out; no I/O beyond reading the file.

``model`` contains the stanzas, ``reading`` builds them from a file, ``rules`` finds settings that make no sense
together.
"""

from ._address import MODBUS_SCHEMES, NetworkAddress, has_line, network_address, refused_fieldbus, right_form
from ._content import content_hash, hash_of
from ._fault import CODES, Fault, did_you_mean
from ._paths import SHIPPED_AUTOMATA, profile_names, profile_path, run_directory, tool_path
from ._reference import markdown, schema, schema_path, schema_text
from .devices._library import CONFIRMED, DeviceLibrary, LibraryDevice
from .model._channels import (
    NUMBER,
    QUANTITIES,
    Channel,
    DeviceAlarm,
    DigitalInput,
    Inputs,
    JsonValue,
    ModbusFrame,
    RecordFrame,
    RecordValue,
    RegisterValue,
    TextFrame,
    TextValue,
    mask_shift,
    part_of,
    raw_limits,
    type_bits,
)
from .model._description import Description, camel_case, socket_path
from .model._stanzas import SAME_FOR_ALL_PARTS, EStop, GrippedPart, Link, ToolChanger
from .reading._examine import examine, examine_text, load
from .rules._channels import CodecChannels, used_channels
from .rules._codec import not_fitted, slow, unproven
from .rules._evidence import BIT, Spans, SpanSearch, Wanted, measures_of, range_kpa, widest
from .rules._outputs import lost_by_silence

__all__ = [
    "BIT",
    "CODES",
    "CONFIRMED",
    "MODBUS_SCHEMES",
    "NUMBER",
    "QUANTITIES",
    "SAME_FOR_ALL_PARTS",
    "SHIPPED_AUTOMATA",
    "Channel",
    "CodecChannels",
    "Description",
    "DeviceAlarm",
    "DeviceLibrary",
    "DigitalInput",
    "EStop",
    "Fault",
    "GrippedPart",
    "Inputs",
    "JsonValue",
    "LibraryDevice",
    "Link",
    "ModbusFrame",
    "NetworkAddress",
    "RecordFrame",
    "RecordValue",
    "RegisterValue",
    "SpanSearch",
    "Spans",
    "TextFrame",
    "TextValue",
    "ToolChanger",
    "Wanted",
    "camel_case",
    "content_hash",
    "did_you_mean",
    "examine",
    "examine_text",
    "has_line",
    "hash_of",
    "load",
    "lost_by_silence",
    "markdown",
    "mask_shift",
    "measures_of",
    "network_address",
    "not_fitted",
    "part_of",
    "profile_names",
    "profile_path",
    "range_kpa",
    "raw_limits",
    "refused_fieldbus",
    "right_form",
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
    "widest",
]
