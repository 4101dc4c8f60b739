"""The ports over which the testbench communicates: serial devices, ptys, and addresses of this machine."""

from __future__ import annotations

import os
import select
import socket
import struct
import time
from contextlib import suppress
from pathlib import Path
from typing import Protocol

import serial

from end_effector_hal.description import NetworkAddress
from end_effector_hal.errors import LinkError
from end_effector_hal.wires.link import PtyPair, open_port

from .devices import crc16, sealed

_BITS_PER_BYTE = 10  # 8N1


class Port(Protocol):
    """Sends frames, and receives requests."""

    @property
    def text(self) -> str:
        """Name of the port for people."""
        ...

    def open(self) -> None:
        """Open the port; raises LinkError."""
        ...

    def send(self, data: bytes) -> int:
        """Send without waiting for a reader; bytes that do not fit are lost, as on a wire.

        Returns:
            Time that the wire needs for the data, µs.

        Raises:
            LinkError: the port has gone.
        """
        ...

    def cut(self, data: bytes) -> None:
        """Send the first half, and reset the connection if the port has one; raises LinkError like `send`."""
        ...

    def refuse(self, *, refuses: bool) -> None:
        """Refuse connections from now on, and reset those there are; or accept them again."""
        ...

    def receive(self, wait_s: float) -> bytes:
        """Return the bytes that arrived, after at most ``wait_s``; b"" if there are none; raises LinkError like
        `send`.
        """
        ...

    def close(self) -> None:
        """Close the port."""
        ...


class WithoutConnections:
    """The part of a `Port` on a wire that concerns connections: it has none."""

    def cut(self: Port, data: bytes) -> None:
        self.send(data[: len(data) // 2])

    def refuse(self, *, refuses: bool) -> None:
        pass


class SerialPort(WithoutConnections):
    """A serial device as a port.

    Args:
        path: path of the device.
        baudrate, parity, stopbits: settings of the device, with 8 data bits.
    """

    def __init__(self, path: str, baudrate: int, parity: str = "N", stopbits: int = 1) -> None:
        self.text = path
        self._baudrate, self._parity, self._stopbits = baudrate, parity, stopbits
        self._serial: serial.Serial | None = None

    def open(self) -> None:
        self._serial = open_port(
            self.text, self._baudrate, parity=self._parity, stopbits=self._stopbits, write_timeout_s=0.5
        )

    def send(self, data: bytes) -> int:
        if self._serial is not None:
            try:
                self._serial.write(data)
            except serial.SerialTimeoutException:
                pass  # flow control holds it back: lost
            except OSError as error:
                raise LinkError(f"the port has gone: {error}.", where=self.text) from error
        return len(data) * _BITS_PER_BYTE * 1_000_000 // self._baudrate

    def receive(self, wait_s: float) -> bytes:
        if self._serial is None:
            return b""
        try:
            return os.read(fd, 4096) if _readable(fd := self._serial.fileno(), wait_s) else b""
        except OSError as error:
            raise LinkError(f"the port has gone: {error}.", where=self.text) from error

    def close(self) -> None:
        if self._serial is not None:
            self._serial.close()


class PtyPort(WithoutConnections):
    """A new pty, reached by a symbolic link.

    Args:
        link: path of the link.
    """

    def __init__(self, link: str) -> None:
        self.text = link
        self._pair: PtyPair | None = None

    def open(self) -> None:
        with suppress(OSError):  # then the pair says why
            Path(self.text).parent.mkdir(parents=True, exist_ok=True)
        self._pair = PtyPair(self.text)

    def send(self, data: bytes) -> int:
        """Send the data; a pty needs no time for it."""
        if self._pair is not None:
            self._pair.write(data)
        return 0

    def receive(self, wait_s: float) -> bytes:
        return self._pair.read() if self._pair is not None and _readable(self._pair.fileno(), wait_s) else b""

    def close(self) -> None:
        if self._pair is not None:
            self._pair.close()


def _readable(fd: int, wait_s: float) -> bool:
    return bool(select.select([fd], [], [], wait_s)[0])


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
        if (client := self._asking) is None:
            return
        sent = b"".join(_framed(client.transaction, data)) if self._tcp else data
        with suppress(OSError):
            client.connection.send(sent[: len(sent) // 2])
        self._reset(client)

    def refuse(self, *, refuses: bool) -> None:
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
