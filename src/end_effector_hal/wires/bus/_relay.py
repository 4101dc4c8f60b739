"""Hands each cycle of a bus on to those who read the sensors, over a Unix socket."""

from __future__ import annotations

import logging
import socket
from pathlib import Path

from end_effector_hal.errors import LinkError
from end_effector_hal.wires._socket import listen

_log = logging.getLogger("end_effector_hal.wires")
MOST_READERS = 8
CONNECT_S = 1.0


def relay_path(arbiter: Path) -> Path:
    """Where the line arbiter that serves this socket hands on what its bus brings."""
    return arbiter.with_name(f"{arbiter.name}.bus")


def connect_relay(path: Path) -> socket.socket:
    """A connection to read cycles from; raises LinkError."""
    reader = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        reader.settimeout(CONNECT_S)
        reader.connect(str(path))
        reader.setblocking(False)
    except OSError as error:
        reader.close()
        raise LinkError(
            f"the line arbiter, which masters this bus, does not hand it on: {error.strerror or error}.",
            where=str(path),
            todo="Start it: eehal arbiter DESCRIPTION, or systemctl start eehal-arbiter.",
        ) from error
    return reader


class RelayServer:
    """One socket, a few readers; who does not read what it gets is dropped, so that nobody waits for it.

    Args:
        path: of the socket; one that was left behind is replaced.
        group: whose members may read; default: that of the process.

    Raises:
        UsageError, WireError: see `listen`.
    """

    def __init__(self, path: Path, group: str | None = None) -> None:
        self._path = path
        self._listener = listen(path, group)
        self._readers: list[socket.socket] = []

    @property
    def sockets(self) -> list[socket.socket]:
        """To wait for; each that is readable is for `ready`."""
        return [self._listener, *self._readers]

    def ready(self, which: socket.socket) -> None:
        """A reader comes, or goes; what one says means nothing."""
        try:
            if which is not self._listener:
                if not which.recv(4096):
                    self._drop(which)
                return
            reader, _ = self._listener.accept()
        except BlockingIOError:
            return
        except OSError:
            if which is not self._listener:
                self._drop(which)
            return
        if len(self._readers) == MOST_READERS:  # not the oldest: that is the program which holds the part
            reader.close()
            return
        reader.setblocking(False)
        self._readers.append(reader)

    def send(self, record: bytes) -> None:
        """One record to all of them."""
        for reader in list(self._readers):
            try:
                whole = reader.send(record) == len(record)
            except OSError:
                whole = False
            if not whole:
                _log.warning("a reader of %s does not keep up: it is dropped", self._path)
                self._drop(reader)

    def close(self) -> None:
        """End, and take the socket away."""
        for reader in list(self._readers):
            self._drop(reader)
        self._listener.close()
        self._path.unlink(missing_ok=True)

    def _drop(self, reader: socket.socket) -> None:
        if reader in self._readers:
            self._readers.remove(reader)
            reader.close()
