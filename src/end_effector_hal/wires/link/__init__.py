"""Links: they deliver sensor frames from a serial port."""

from ._codec_calls import CodecCalls, CodecFailure
from ._guard import WEIGHED_AFTER, GuardedDecoder
from ._port import open_port
from ._pty import PtyPair
from ._reader import LinkHealth, LinkReader, LinkState
