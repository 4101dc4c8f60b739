"""Sockets between the line arbiter and its clients, in virtual time: a message is answered at once, or its end dies."""

from __future__ import annotations

import errno
import os
import struct
from typing import Any, Protocol


class Listener(Protocol):
    """Somebody who accepts connections."""

    def accept(self, far: FarEnd) -> None:
        """Somebody has connected."""

    def hear(self, far: FarEnd) -> None:
        """Somebody has sent something, or has gone."""


class FarEnd:
    """The listener's end of a connection, with the methods of a socket that its `Connection` calls."""

    def __init__(self, near: NearEnd, pid: int) -> None:
        self.near, self._pid = near, pid
        self.incoming, self.is_open, self.ended = b"", True, False

    def setblocking(self, _: bool) -> None:
        """It never waits."""

    def getsockopt(self, *_: int) -> bytes:
        """Who is at the other end."""
        return struct.pack("3i", self._pid, 0, 0)

    def recv(self, _: int) -> bytes:
        data, self.incoming = self.incoming, b""
        if not data and not self.ended:
            raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN))
        return data

    def send(self, data: bytes) -> int:
        if not self.near.is_open:
            raise BrokenPipeError(errno.EPIPE, os.strerror(errno.EPIPE))
        self.near.incoming += data
        return len(data)

    def fileno(self) -> int:
        return 3 if self.is_open else -1

    def close(self) -> None:
        self.is_open = False
        self.near.is_lost = True


class NearEnd:
    """The client's end, with the methods of a socket that a `Conversation` calls."""

    def __init__(self, world: Any) -> None:
        self._world = world
        self.incoming, self.is_open, self.is_lost = b"", False, False
        self._far: FarEnd | None = None
        self._listener: Listener | None = None

    def settimeout(self, _: float | None) -> None:
        """Nobody waits in here."""

    def setsockopt(self, *_: object) -> None:
        """Nobody waits in here."""

    def connect(self, _: str) -> None:
        self._listener = self._world.listener
        if self._listener is None:
            raise ConnectionRefusedError(errno.ECONNREFUSED, os.strerror(errno.ECONNREFUSED))
        self.is_open = True
        self._far = FarEnd(self, self._world.pid())
        self._world.ends.append(self)
        self._listener.accept(self._far)

    def sendall(self, data: bytes) -> None:
        if self.is_lost or not self._far or not self._listener:
            raise BrokenPipeError(errno.EPIPE, os.strerror(errno.EPIPE))
        self._far.incoming += data
        self._listener.hear(self._far)

    def recv(self, _: int) -> bytes:
        data, self.incoming = self.incoming, b""
        if not data and not self.is_lost:
            raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN))
        return data

    def close(self) -> None:
        """Also by the kernel, when the process dies."""
        if self.is_open:
            self.is_open = False
            self._world.ends.remove(self)
            if self._far and not self.is_lost and self._listener:
                self._far.ended = True
                self._listener.hear(self._far)
