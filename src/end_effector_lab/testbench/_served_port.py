"""An address of this machine as a port of the testbench: it serves the simulated device to its clients."""

from __future__ import annotations

import select
import socket
import struct
import time
from contextlib import suppress

from end_effector_hal.description import NetworkAddress
from end_effector_hal.errors import LinkError

from .devices import crc16, sealed

_HEADER = 6
_MOST_CLIENTS = 8


class ServedClient:
    """One connection, and the bytes of its unfinished request."""

    def __init__(self, connection: socket.socket) -> None:
        self.connection = connection
        self.rest = b""
        self.transaction = b"\0\0"


class ServedPort:
    """A server of Modbus TCP, or of plain bytes (RTU frames, text, records).

    Args:
        address: of this machine.
    """

    def __init__(self, address: NetworkAddress) -> None:
        self.text = str(address)
        self._address, self._tcp = address, address.scheme == "tcp"
        self._server: socket.socket | None = None
        self._clients: list[ServedClient] = []
        self._asking: ServedClient | None = None

    def open(self) -> None:
        """Listen; raises LinkError."""
        where = self._address.host, self._address.port
        try:
            family, *_, found = socket.getaddrinfo(*where, type=socket.SOCK_STREAM)[0]
            self._server = socket.create_server(found[:2], family=family)
        except OSError as error:
            raise LinkError(
                f"the simulated device cannot be served here: {error.strerror}.",
                where=self.text,
                todo="`eehal testbench --prepare FOLDER` writes a copy of the tool with addresses of this machine.",
            ) from error
        self._server.setblocking(False)

    def send(self, data: bytes) -> int:
        """Send an answer to the client that asked, or a frame to all of them; a network needs no time for it."""
        self._accept()  # a port that sends without requests never receives
        asking = [self._asking] if self._asking else []
        for client in asking if self._tcp else asking or list(self._clients):
            sent = b"".join(_framed(client.transaction, data)) if self._tcp else data
            try:
                client.connection.send(sent)
            except BlockingIOError:
                continue
            except OSError:
                self._drop(client)
        return 0

    def cut(self, data: bytes) -> None:
        """Send the first half of an answer, and reset the connection."""
        if (client := self._asking) is None:
            return
        sent = b"".join(_framed(client.transaction, data)) if self._tcp else data
        with suppress(OSError):
            client.connection.send(sent[: len(sent) // 2])
        self._reset(client)

    def refuse(self, *, refuses: bool) -> None:
        """Refuse connections from now on, and reset those there are; or accept them again."""
        if refuses is (self._server is None):
            return
        if not refuses:
            self.open()
            return
        for client in list(self._clients):
            self._reset(client)
        if self._server is not None:
            self._server.close()
            self._server = None

    def receive(self, wait_s: float) -> bytes:
        """Return the next request, as a frame of RTU, or bytes that arrived; b"" if there are none."""
        if self._server is None:
            time.sleep(wait_s)
            return b""
        for client in self._clients:
            if request := self._request(client):
                return request
        ready = select.select([self._server, *(each.connection for each in self._clients)], [], [], wait_s)[0]
        if self._server in ready:
            self._accept()
        for client in [each for each in self._clients if each.connection in ready]:
            try:
                data = client.connection.recv(4096)
            except OSError:
                data = b""
            if not data:
                self._drop(client)
            client.rest += data
            if data and (request := self._request(client)):
                return request
        return b""

    def close(self) -> None:
        """Close all connections."""
        for client in list(self._clients):
            self._drop(client)
        if self._server is not None:
            self._server.close()

    def _accept(self) -> None:
        if self._server is None:
            return
        with suppress(OSError):
            connection, _ = self._server.accept()
            connection.setblocking(False)
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._clients.append(ServedClient(connection))
            if len(self._clients) > _MOST_CLIENTS:
                self._drop(self._clients[0])

    def _request(self, client: ServedClient) -> bytes:
        if not self._tcp:
            request, client.rest = client.rest, b""
        else:
            size = int.from_bytes(client.rest[4:_HEADER], "big")
            if len(client.rest) < _HEADER or len(client.rest) < _HEADER + size:
                return b""
            client.transaction = client.rest[:2]
            request = sealed(client.rest[_HEADER : _HEADER + size])
            client.rest = client.rest[_HEADER + size :]
        if request:
            self._asking = client
        return request

    def _reset(self, client: ServedClient) -> None:
        client.connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self._drop(client)

    def _drop(self, client: ServedClient) -> None:
        if client in self._clients:
            self._clients.remove(client)
        client.connection.close()
        if self._asking is client:
            self._asking = None


def _framed(transaction: bytes, data: bytes) -> list[bytes]:
    """Return the frames of Modbus TCP of an answer, which may be there twice; a damaged one does not arrive."""
    half = data[: len(data) // 2]
    answers = [half, half] if half + half == data else [data]
    good = [each for each in answers if crc16(each[:-2]) == each[-2:]]
    return [transaction + bytes(2) + (len(each) - 2).to_bytes(2, "big") + each[:-2] for each in good]
