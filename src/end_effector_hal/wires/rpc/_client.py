"""A client whose calls block until the answer arrives."""

from __future__ import annotations

import socket
import struct
import time
from contextlib import suppress
from pathlib import Path

from pydantic_core import from_json

from ._messages import VALID_US, Reply, read_answer, request_line

LONGEST_LINE = 4_000_000
"""Longest line of a server, bytes."""
READ_BYTES = 262_144
ANSWER_S = 10.0
"""Longest wait of `ask`, s: the program may load and check a description."""


class Client:
    """A blocking client. It is not connected before `connect`, nor after `close`. Not thread-safe, except `abort`.

    Args:
        path: the socket.
        timeout_s: longest wait of a call; None: no limit.
    """

    def __init__(self, path: str | Path, timeout_s: float | None) -> None:
        self.path, self._timeout_s = str(path), timeout_s
        self._socket: socket.socket | None = None
        self._rest = b""
        self.connected = False
        """Whether the connection was open at the last call."""

    def connect(self, timeout_s: float | None = None) -> None:
        """Connect within ``timeout_s`` (default: the time-out of the client); raises OSError."""
        self._socket, self._rest = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM), b""
        self._socket.settimeout(self._timeout_s if timeout_s is None else timeout_s)
        try:
            self._socket.connect(self.path)
        except OSError:
            self.close()
            raise
        if self._timeout_s is not None:
            # Time-outs of the kernel: with those of Python each call would be preceded by a poll.
            limit = struct.pack("@ll", int(self._timeout_s), round(self._timeout_s % 1 * 1e6))
            for option in (socket.SO_RCVTIMEO, socket.SO_SNDTIMEO):
                self._socket.setsockopt(socket.SOL_SOCKET, option, limit)
        self._socket.settimeout(None)
        self.connected = True

    def fileno(self) -> int:
        """Return the socket's descriptor, for select."""
        assert self._socket
        return self._socket.fileno()

    def send(self, line: bytes) -> None:
        """Send a line; raises OSError."""
        assert self._socket
        self._socket.sendall(line)

    def receive(self) -> bytes:
        """Return the next line.

        Raises:
            BlockingIOError: no line arrived in time.
            OSError: the connection is closed, or the line is too long.
        """
        assert self._socket
        while b"\n" not in self._rest:
            if not (data := self._socket.recv(READ_BYTES)):
                raise OSError("it closed the connection")
            if len(self._rest) > LONGEST_LINE:
                raise OSError("its message is too long")
            self._rest += data
        line, self._rest = self._rest.split(b"\n", 1)
        return line

    def abort(self) -> None:
        """Make a `receive` that waits in another thread fail."""
        if (sock := self._socket) is not None:
            with suppress(OSError):
                sock.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """Close the connection."""
        self.connected = False
        if self._socket:
            self._socket.close()
            self._socket = None


def ask(path: Path, who: str, **fields: object) -> Reply:
    """Send one request and wait for its answer; returns a reply in any case.

    Args:
        path: the socket.
        who: the program that serves it, as the beginning of a sentence.
        fields: the fields of the request.
    """
    client, until = Client(path, ANSWER_S), time.monotonic() + ANSWER_S
    try:
        client.connect()
        client.send(request_line(1, VALID_US, fields))
        while time.monotonic() < until:
            answer = read_answer(from_json(client.receive()))
            if answer is not None and answer[0] == 1:
                return answer[1]
    except (FileNotFoundError, ConnectionRefusedError):
        return Reply(False, f"{who} does not run: no process listens at {path}.", decided=False)
    except BlockingIOError:
        pass
    except (OSError, ValueError, KeyError, TypeError) as error:
        why = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        return Reply(False, f"{who} cannot be asked ({path}): {why}.", decided=False)
    finally:
        client.close()
    return Reply(False, f"{who} does not answer ({path}).", decided=False)
