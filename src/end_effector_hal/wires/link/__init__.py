"""Links: they deliver sensor frames from a serial port."""

from ._guard import CodecCalls, GuardedDecoder
from ._port import open_port
from ._pty import PtyPair
from ._reader import LinkHealth, LinkState
