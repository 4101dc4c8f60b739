"""Links: they deliver sensor frames from a serial port."""

from end_effector_hal.wires.link._codec_calls import CodecCalls, CodecFailure
from end_effector_hal.wires.link._guard import GuardedDecoder
from end_effector_hal.wires.link._health import LinkHealth, LinkState
from end_effector_hal.wires.link._port import open_port
from end_effector_hal.wires.link._pty import PtyPair
from end_effector_hal.wires.link._reader import LinkReader

__all__ = [
    "CodecCalls",
    "CodecFailure",
    "GuardedDecoder",
    "LinkHealth",
    "LinkReader",
    "LinkState",
    "PtyPair",
    "open_port",
]
