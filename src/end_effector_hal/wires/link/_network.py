"""A port that is an address in a network. It connects in the background, and is read and written without waiting."""

from __future__ import annotations

import errno
import os
import socket
import struct
import threading
import time
from typing import Protocol

from end_effector_hal.description import NetworkAddress
from end_effector_hal.errors import LinkError
from end_effector_hal.wires._claim import AddressClaim

from ._telnet import SerialSettings, TelnetFrames

CONNECT_S = 3.0
"""Longest wait for each address of a host to accept the connection, s."""
KEEP_ALIVE = {"TCP_KEEPIDLE": 2, "TCP_KEEPINTVL": 1, "TCP_KEEPCNT": 3, "TCP_USER_TIMEOUT": 900}
"""A silent peer is asked after 2 s, then again. What it does not acknowledge the kernel sends for 0.9 s only: an
activation that was given up (after 1 s) must not arrive when the cable is back.
"""
DISCARD = struct.pack("ii", 1, 0)
"""SO_LINGER: with the connection ends what was not sent, or it would arrive after writes of the next connection."""
DEAF_REQUESTS, DEAF_S = 4, 3.0
"""Least number of requests without an answer, and their least time, before the connection is made again."""
READ_BYTES = 4096
_WHERE_TO_LOOK = "Is the device switched on? Check cable, address and firewall."
_WRONG_SCHEME = "Does the scheme of the port fit the device? docs/how-to/network.md has all schemes."
_UNREACHABLE = (errno.EHOSTUNREACH, errno.ETIMEDOUT, errno.EHOSTDOWN)
_NO_NETWORK = (errno.ENETUNREACH, errno.EAFNOSUPPORT, errno.ENETDOWN, errno.EPERM, errno.EACCES)


class WireFrames(Protocol):
    """How data are encoded on the connection, sans-IO."""

    def request(self, frame: bytes) -> bytes:
        """Return the bytes to send for some data."""
        ...

    def feed(self, data: bytes) -> bytes:
        """Return the data in received bytes; raises ValueError if they make no sense."""
        ...


class RawFrames:
    """Data as they are: frames of RTU, text, records."""

    def request(self, frame: bytes) -> bytes:
        return frame

    def feed(self, data: bytes) -> bytes:
        return data


class NetworkPort:
    """A connection to a device or a gateway; a name is resolved, and the connection made, in a thread of its own.

    While `connecting`, `fileno` becomes readable when that is over; then call `establish`.

    Args:
        address: where the device is; only one port on this machine may use it.
        settings: of the serial line at the far end; only `rfc2217` sets it.

    Raises:
        LinkBusyError: another link or program uses this address; the message names it.
    """

    def __init__(self, address: NetworkAddress, settings: SerialSettings) -> None:
        self._address = address
        self._claim = AddressClaim(address.place)
        self._frames = frames_of(address, settings)
        self._lock, self._closed = threading.Lock(), False
        self._socket: socket.socket | None = None
        self._error: Exception | None = None
        self._unanswered, self._unanswered_since = 0, 0.0
        self._done, self._finish = os.pipe()
        self.connecting = True
        try:
            threading.Thread(target=self._connect, name=f"connect {address}", daemon=True).start()
        except BaseException:  # or this process would keep the address from itself
            os.close(self._finish)
            self.close()
            raise

    def establish(self) -> None:
        """End the connecting; raises LinkError with the reason if there is no connection."""
        self.connecting = False
        os.close(self._done)
        if self._socket is None or self._error is not None:
            raise self._explained(self._error)
        if isinstance(self._frames, TelnetFrames):
            self._send(self._frames.greeting)

    def fileno(self) -> int:
        """Return the descriptor for select."""
        return self._done if self._socket is None or self.connecting else self._socket.fileno()

    def read(self) -> bytes:
        """Return received data, b"" if nothing is complete yet; raises OSError when the connection is lost."""
        assert self._socket is not None
        try:
            received = self._socket.recv(READ_BYTES)
        except BlockingIOError:
            return b""
        if not received:
            raise self._lost("the far end has closed the connection")
        try:
            data = self._frames.feed(received)
        except ValueError as error:
            raise self._lost(str(error), _WRONG_SCHEME) from None
        if isinstance(self._frames, TelnetFrames) and (reply := self._frames.reply()):
            self._send(reply)
        if data:
            self._unanswered = 0
        return data

    def write(self, data: bytes) -> None:
        """Send a request; raises OSError when too many had no answer, or the far end does not read."""
        now = time.monotonic()
        if not self._unanswered:
            self._unanswered_since = now
        elif self._unanswered >= DEAF_REQUESTS and now - self._unanswered_since >= DEAF_S:
            raise self._lost(f"no answer for {now - self._unanswered_since:.0f} s")
        self._unanswered += 1
        self._send(self._frames.request(data))

    def close(self) -> None:
        """Close the connection, or let the thread that makes it do so."""
        with self._lock:
            closed, self._closed = self._closed, True
            if self._socket is not None:
                self._socket.close()
        if closed:
            return
        if self.connecting:
            os.close(self._done)
        self._claim.release()

    def _send(self, data: bytes) -> None:
        assert self._socket is not None
        try:
            sent = self._socket.send(data)
        except BlockingIOError:
            sent = 0
        if sent not in (0, len(data)):  # the rest would come in the middle of the next frame
            raise self._lost("the far end does not read")

    def _connect(self) -> None:
        try:
            opened = socket.create_connection((self._address.host, self._address.port), CONNECT_S)
            with self._lock:
                self._socket = opened
                if self._closed:
                    opened.close()
                    return
            opened.setblocking(False)
            opened.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            opened.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
            opened.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, DISCARD)
            for name, value in KEEP_ALIVE.items():
                opened.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
        except Exception as error:  # noqa: BLE001 a resolver may raise anything; the user of the port says what it was
            self._error = error
        finally:
            os.close(self._finish)

    def _lost(self, what: str, todo: str = _WHERE_TO_LOOK) -> LinkError:
        return LinkError(f"the connection is lost: {what}.", where=str(self._address), todo=todo)

    def _explained(self, error: Exception | None) -> LinkError:
        number, where = getattr(error, "errno", None), str(self._address)
        if isinstance(error, socket.gaierror | UnicodeError):
            todo = "Check the name and the name server of the network, or give the IP address."
            return LinkError(f"the name {self._address.host} cannot be resolved.", where=where, todo=todo)
        if number == errno.ECONNREFUSED:
            todo = f"Is {self._address.port} the right port number? Is the service on at the device?"
            return LinkError("the connection is refused.", where=where, todo=todo)
        if isinstance(error, TimeoutError) or number in _UNREACHABLE:
            return LinkError("the device does not answer.", where=where, todo=_WHERE_TO_LOOK)
        if number in _NO_NETWORK:
            todo = "A service of systemd needs an entry for it: docs/how-to/network.md."
            return LinkError("this program may not use the network, or has none.", where=where, todo=todo)
        what = getattr(error, "strerror", None) or str(error)
        return LinkError(f"it cannot be reached: {what}.", where=where, todo=_WHERE_TO_LOOK)


def frames_of(address: NetworkAddress, settings: SerialSettings) -> WireFrames:
    """Return how data are encoded on a connection to this address."""
    if address.scheme == "tcp":
        from end_effector_hal.codecs.modbus import TcpFrames

        return TcpFrames()
    return TelnetFrames(settings) if address.scheme == "rfc2217" else RawFrames()
