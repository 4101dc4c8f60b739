"""Hands what the line arbiter reads on to those who read the sensors, over a Unix socket."""

from __future__ import annotations

import logging
import socket
from pathlib import Path

from end_effector_hal.errors import LinkError
from end_effector_hal.wires._acceptor import Acceptor
from end_effector_hal.wires._socket import listen

_log = logging.getLogger("end_effector_hal.wires")
MOST_READERS = 8
CONNECT_S = 1.0


def relay_path(arbiter: Path, what: str = "bus") -> Path:
    """Where the line arbiter that serves this socket hands on what its bus, or its inputs, bring."""
    return arbiter.with_name(f"{arbiter.name}.{what}")


def connect_relay(path: Path, what: str = "masters this bus, does not hand it on") -> socket.socket:
    """A connection to read from; raises LinkError.

    Args:
        path: of the relay.
        what: the line arbiter does and does not, for the sentence.
    """
    reader = None
    try:
        reader = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        reader.settimeout(CONNECT_S)
        reader.connect(str(path))
        reader.setblocking(False)
    except OSError as error:
        if reader is not None:
            reader.close()
        raise LinkError(
            f"the line arbiter, which {what}: {error.strerror or error}.",
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
        self._acceptor = Acceptor(listen(path, group), str(path), path)
        self._readers: list[socket.socket] = []

    @property
    def sockets(self) -> list[socket.socket]:
        """To wait for; each that is readable is for `ready`."""
        return [self._acceptor.listener, *self._readers]

    def ready(self, which: socket.socket) -> None:
        """A reader comes, or goes; what one says means nothing."""
        if which is not self._acceptor.listener:
            self._heard(which)
            return
        if (reader := self._acceptor.accept()) is None:
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
        self._acceptor.close()

    def _heard(self, reader: socket.socket) -> None:
        try:
            goes_on = bool(reader.recv(4096))
        except BlockingIOError:
            return
        except OSError:
            goes_on = False
        if not goes_on:
            self._drop(reader)

    def _drop(self, reader: socket.socket) -> None:
        if reader in self._readers:
            self._readers.remove(reader)
            reader.close()
