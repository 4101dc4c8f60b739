"""The arbiter's end of one connection: the process at the other end, and its messages that are not answered yet."""

from __future__ import annotations

import socket
import struct
from collections.abc import Mapping

from end_effector_hal.arbiter.protocol import LONGEST, write_message
from end_effector_hal.arbiter.rules import Session, process_words
from end_effector_hal.wires import program_name


class Connection:
    """Reads without waiting, one message after the other, and no further than `receive` is called.

    Args:
        sock: accepted; it is closed by `close`.
        at: now, µs.
    """

    def __init__(self, sock: socket.socket, at: int) -> None:
        sock.setblocking(False)
        self.sock = sock
        self.pid, self.uid, _ = struct.unpack(
            "3i", sock.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, 12)
        )
        self.program = program_name(self.pid) if self.pid else ""
        self.session: Session | None = None
        self.sends_predicates = False
        self.heard_at = at
        self.ended = False
        """The other end is closed; what it sent before is still to be answered."""
        self._rest = b""

    @property
    def process(self) -> str:
        """The process at the other end, for people."""
        return process_words(self.pid, self.program)

    @property
    def rank(self) -> int:
        """The order of answers: what the sensors prove was sent before any write that follows from it."""
        return 0 if self.sends_predicates else 1 if self.session else 2

    @property
    def waits(self) -> bool:
        """Whether a whole message was received and is not fetched yet."""
        return b"\n" in self._rest

    @property
    def overlong(self) -> bool:
        """Whether more came than any message is long."""
        return not self.waits and len(self._rest) > LONGEST

    def receive(self) -> None:
        """Read what is there; nothing while messages wait, so that a flood fills the buffers of its sender."""
        if self.waits or self.ended:
            return
        try:
            data = self.sock.recv(LONGEST)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        self.ended, self._rest = not data, self._rest + data

    def next_message(self) -> bytes | None:
        """Fetch the next message; None: there is no whole one."""
        if not self.waits:
            return None
        line, self._rest = self._rest.split(b"\n", 1)
        return line

    def send(self, message: Mapping[str, object]) -> bool:
        """Returns whether the whole message went out; a client that does not read its replies is treated as dead."""
        data = write_message(message)
        try:
            return self.sock.send(data) == len(data)
        except OSError:
            return False

    @property
    def closed(self) -> bool:
        return self.sock.fileno() < 0

    def close(self) -> None:
        self.sock.close()
