"""The wires of an end-effector: lines (binary outputs), links (sensor frames), codecs, and the line owner.

Pure, for those who must not touch a clock or a socket: `wires.frame`, `wires.codecs`, `wires.will`.
"""

from end_effector_hal.wires._claim import program_name
from end_effector_hal.wires._clock import now_us
from end_effector_hal.wires._load import Fitting, fitting, load_tool
from end_effector_hal.wires._steady import be_steady
from end_effector_hal.wires._text import printable
from end_effector_hal.wires.codecs import Codec, Decoder, codec_names, get_codec
from end_effector_hal.wires.frame import Frame, Kind, Value
from end_effector_hal.wires.lines import (
    ChipState,
    ChipWatcher,
    Edge,
    GpiodLines,
    HandsOn,
    LineBackend,
    LineState,
    VirtualChip,
    VirtualLines,
    read_chip,
)
from end_effector_hal.wires.link import LinkHealth, LinkReader, LinkState, PtyPair, open_port
from end_effector_hal.wires.owner import (
    Exclusion,
    LineOwner,
    Need,
    OwnerClient,
    Policy,
    Teller,
    Written,
    serve,
)
from end_effector_hal.wires.will import Will, WillStep

__all__ = [
    "ChipState",
    "ChipWatcher",
    "Codec",
    "Decoder",
    "Edge",
    "Exclusion",
    "Fitting",
    "Frame",
    "GpiodLines",
    "HandsOn",
    "Kind",
    "LineBackend",
    "LineOwner",
    "LineState",
    "LinkHealth",
    "LinkReader",
    "LinkState",
    "Need",
    "OwnerClient",
    "Policy",
    "PtyPair",
    "Teller",
    "Value",
    "VirtualChip",
    "VirtualLines",
    "Will",
    "WillStep",
    "Written",
    "be_steady",
    "codec_names",
    "fitting",
    "get_codec",
    "load_tool",
    "now_us",
    "open_port",
    "printable",
    "program_name",
    "read_chip",
    "serve",
]
