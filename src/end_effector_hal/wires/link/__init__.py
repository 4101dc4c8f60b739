"""Links: they deliver sensor frames from a serial port."""

from ._codec_calls import CodecCalls, CodecFailure
from ._guard import GuardedDecoder
from ._health import LinkHealth, LinkState
from ._port import open_port
from ._pty import PtyPair
from ._reader import LinkReader

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
