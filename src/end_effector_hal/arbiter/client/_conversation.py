"""Requests to the line arbiter and its replies, one after the other over one socket."""

from __future__ import annotations

import socket
import struct
from collections.abc import Mapping
from typing import Any

from end_effector_hal.arbiter.protocol import LastWillRunsError, read_reply, write_message
from end_effector_hal.errors import ArbiterError, LineBusyError, LineRefusedError, ReportedError, UsageError
from end_effector_hal.vocabulary import LONGEST_MESSAGE, printable

_ERRORS: dict[str, type[ReportedError]] = {
    error.code: error for error in (UsageError, LineBusyError, LineRefusedError, ArbiterError)
}

LONGEST_REPLY = 1 << 22


class Conversation:
    """Not connected at first, nor after the connection was lost. Not thread-safe.

    Args:
        path: of the arbiter's socket.
        timeout_s: longest wait for a reply.
    """

    def __init__(self, path: str, timeout_s: float) -> None:
        self._path, self._timeout_s = path, timeout_s
        self._socket: socket.socket | None = None
        self._rest = b""
        self._number = 0

    @property
    def connected(self) -> bool:
        """Whether it is connected, as far as the last exchange showed."""
        return self._socket is not None

    def connect(self) -> None:
        """Connect; raises ArbiterError."""
        self._socket, self._rest = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM), b""
        self._socket.settimeout(self._timeout_s)
        try:
            self._socket.connect(self._path)
        except OSError as error:
            self.close()
            raise ArbiterError(
                f"the line arbiter cannot be reached: {error.strerror or error}.",
                where=self._path,
                todo="Start it: eehal arbiter DESCRIPTION.",
            ) from error
        # Time-outs of the kernel: with those of Python each call would be preceded by a poll.
        limit = struct.pack("@ll", int(self._timeout_s), round(self._timeout_s % 1 * 1e6))
        for option in (socket.SO_RCVTIMEO, socket.SO_SNDTIMEO):
            self._socket.setsockopt(socket.SOL_SOCKET, option, limit)
        self._socket.settimeout(None)

    def close(self) -> None:
        """Close the socket."""
        if self._socket:
            self._socket.close()
            self._socket = None

    def exchange(self, op: str, fields: Mapping[str, object]) -> dict[str, Any]:
        """Send a request and wait for its reply; raises what `reply` does."""
        return self.reply(self.send(op, fields))

    def send(self, op: str, fields: Mapping[str, object]) -> OSError | None:
        """Send a request; returns the error if that failed, for `reply`, which must follow."""
        assert self._socket
        self._number += 1
        try:
            self._socket.sendall(write_message({"id": self._number, "op": op, **fields}))
        except BrokenPipeError:
            pass  # a connection that the arbiter closed may still hold its last message
        except OSError as error:
            return error
        return None

    def reply(self, failed: OSError | None = None) -> dict[str, Any]:
        """Wait for the reply to what was sent.

        Raises:
            ArbiterError: the arbiter is gone or does not answer; the connection is closed.
            ReportedError: the refusal of the arbiter.
        """
        try:
            if failed is not None:
                raise failed
            reply = self._receive()
        except (OSError, UsageError) as error:
            self.close()
            silent = isinstance(error, TimeoutError | BlockingIOError)
            text = "does not answer" if silent else f"was lost: {error}"
            raise ArbiterError(
                f"the line arbiter {text}.", where=self._path, todo="Levels may have changed: read them."
            ) from error
        if reply.get("ok"):
            return reply
        if reply.get("id") is None:
            self.close()
        raise _error(reply)

    def _receive(self) -> dict[str, Any]:
        assert self._socket
        while b"\n" not in self._rest:
            data = self._socket.recv(LONGEST_MESSAGE)
            if not data:
                raise OSError("it closed the connection")
            if len(self._rest) > LONGEST_REPLY:
                raise OSError("its reply has no end")
            self._rest += data
        line, self._rest = self._rest.split(b"\n", 1)
        return read_reply(line)


def _error(reply: Mapping[str, Any]) -> ReportedError:
    text, retry_us = printable(str(reply.get("error"))), reply.get("retry_us")
    if isinstance(retry_us, int):
        return LastWillRunsError(text, retry_us)
    return _ERRORS.get(str(reply.get("code")), ArbiterError)(text)
