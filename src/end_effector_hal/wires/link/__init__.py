"""Links: they deliver sensor frames from a serial port, or from an address in a network."""

from ._guard import CodecCalls, GuardedDecoder
from ._port import WirePort, open_port, open_wire, users_of
from ._pty import PtyPair
from ._reader import LinkHealth, LinkState
