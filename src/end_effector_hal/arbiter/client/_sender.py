"""Sends predicates to the line arbiter; never waits for it."""

from __future__ import annotations

import logging
import socket
from collections.abc import Mapping
from pathlib import Path

from end_effector_hal.arbiter.protocol import SENSORS, make_token, read_object, write_message
from end_effector_hal.errors import ArbiterError, UsageError
from end_effector_hal.vocabulary import LONGEST_MESSAGE, printable
from end_effector_hal.wires import now_us

_log = logging.getLogger("end_effector_hal.arbiter")
AGAIN_US = 200_000
"""Pause after a refusal, µs: another process reads the sensors and may end soon."""


class PredicateSender:
    """A connection with the role ``sensors`` that reconnects whenever possible. Not thread-safe.

    A report that cannot be sent at once is discarded: later it would be too old.

    Args:
        socket_path: the socket of the arbiter; it need not exist yet.
    """

    def __init__(self, socket_path: str | Path) -> None:
        self._path, self._token = str(socket_path), make_token()
        self._socket: socket.socket | None = None
        self._rest, self._received = b"", b""
        self._not_before, self._refused = 0, ""

    def send(self, predicates: Mapping[str, bool], at_us: int) -> bool:
        """Send predicates; return whether the whole message was sent.

        Args:
            predicates: whether each predicate holds, by name; see `Need`.
            at_us: time at which the sensors proved them, monotonic clock.
        """
        if now_us() < self._not_before:
            return False
        try:
            sock = self._connected()
            # A message that was cut is ended first, so that the next one can be read.
            data = self._rest + write_message({"op": "tell", "at_us": at_us, "predicates": predicates})
            sent = sock.send(data)
            self._rest = data[sent:]
            self._read_replies(sock)
        except BlockingIOError:
            return False
        except OSError as error:
            self._failed(error)
            return False
        return not self._rest

    def close(self) -> None:
        """Close the connection."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None
        self._rest = self._received = b""

    def _connected(self) -> socket.socket:
        if self._socket is None:
            sock = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            sock.setblocking(False)
            try:
                sock.connect(self._path)
            except OSError:
                sock.close()
                raise
            self._socket = sock
            hello = {"op": "hello", "role": SENSORS, "client": SENSORS, "token": self._token}
            self._rest = write_message({"id": 0, **hello})
        return self._socket

    def _read_replies(self, sock: socket.socket) -> None:
        """Raise ArbiterError if the arbiter has refused a message or closed the connection."""
        try:
            data = sock.recv(LONGEST_MESSAGE)
        except BlockingIOError:
            return
        if not data:
            raise ArbiterError("the line arbiter has closed the connection.")
        *lines, self._received = (self._received + data)[-2 * LONGEST_MESSAGE :].split(b"\n")
        for line in lines:
            try:
                reply = read_object(line)
            except UsageError:
                continue
            if not reply.get("ok"):
                self._not_before = now_us() + AGAIN_US
                raise ArbiterError(printable(str(reply.get("error"))))
            self._refused = ""

    def _failed(self, error: OSError) -> None:
        if self._socket is not None and str(error) != self._refused:
            self._refused = str(error)
            _log.warning("the predicates cannot be sent to the line arbiter: %s", error)
        self.close()
