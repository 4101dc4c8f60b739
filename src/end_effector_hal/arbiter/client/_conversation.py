"""Exchanges requests and replies with the line arbiter, one at a time over one socket."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from end_effector_hal.arbiter.protocol import LastWillRunsError, read_object, write_message
from end_effector_hal.errors import ArbiterError, LineBusyError, LineRefusedError, ReportedError, UsageError
from end_effector_hal.vocabulary import printable
from end_effector_hal.wires.rpc import Client

_ERRORS: dict[str, type[ReportedError]] = {
    error.code: error for error in (UsageError, LineBusyError, LineRefusedError, ArbiterError)
}


class Conversation(Client):
    """A client that numbers its requests and raises a refusal as the matching error."""

    _number = 0

    def connect(self, timeout_s: float | None = None) -> None:
        """Connect; raises ArbiterError."""
        try:
            super().connect(timeout_s)
        except OSError as error:
            raise ArbiterError(
                f"the line arbiter cannot be reached: {error.strerror or error}.",
                where=self.path,
                todo="Start it: eehal arbiter DESCRIPTION.",
            ) from error

    def exchange(self, op: str, fields: Mapping[str, object]) -> dict[str, Any]:
        """Send a request and wait for its reply; raises the errors of `reply`."""
        return self.reply(self.request(op, fields))

    def request(self, op: str, fields: Mapping[str, object]) -> OSError | None:
        """Send a request; return the error if that failed. `reply` must follow and receives this error."""
        self._number += 1
        try:
            self.send(write_message({"id": self._number, "op": op, **fields}))
        except BrokenPipeError:
            pass  # a connection that the arbiter closed may still hold its last message
        except OSError as error:
            return error
        return None

    def reply(self, failed: OSError | None = None) -> dict[str, Any]:
        """Wait for the reply to the request just sent.

        Raises:
            ArbiterError: the arbiter is gone or does not answer; the connection is closed.
            ReportedError: the arbiter refuses the request.
        """
        try:
            if failed is not None:
                raise failed
            reply = read_object(self.receive())
        except (OSError, UsageError) as error:
            self.close()
            silent = isinstance(error, TimeoutError | BlockingIOError)
            text = "does not answer" if silent else f"was lost: {error}"
            raise ArbiterError(
                f"the line arbiter {text}.", where=self.path, todo="Levels may have changed: read them."
            ) from error
        if reply.get("ok"):
            return reply
        if reply.get("id") is None:
            self.close()
        raise _error(reply)


def _error(reply: Mapping[str, Any]) -> ReportedError:
    text, retry_us = printable(str(reply.get("error"))), reply.get("retry_us")
    if isinstance(retry_us, int):
        return LastWillRunsError(text, retry_us)
    return _ERRORS.get(str(reply.get("code")), ArbiterError)(text)
