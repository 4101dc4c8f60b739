"""What the owner does at a request, and what it replies."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Mapping
from typing import Any

from end_effector_hal.arbiter.protocol import SENSORS, Request, read_id, read_message, read_request
from end_effector_hal.arbiter.records import Records
from end_effector_hal.arbiter.rules import LastWillRunsError, LineArbiter, SecondSenderError, SenderRole
from end_effector_hal.arbiter.server._connection import Connection
from end_effector_hal.arbiter.server._report import report
from end_effector_hal.errors import ArbiterError, ReportedError
from end_effector_hal.wires import now_us

_log = logging.getLogger("end_effector_hal.arbiter")
SECOND = "sensors"
"""The fault that somebody else claims to read the sensors."""


class Answers:
    """From requests to replies.

    Args:
        keeper: the rules of the lines.
        read_levels: of all lines, from the hardware.
        unclean: the owner before this one did not end in order.
        records: what the next owner must know is kept before anybody is told.
        drop: ends a connection, for the reason that is given.
    """

    def __init__(
        self,
        keeper: LineArbiter,
        read_levels: Callable[[], Mapping[str, bool]],
        *,
        unclean: bool,
        records: Records,
        drop: Callable[[Connection, str], None],
    ) -> None:
        self._keeper, self._read_levels, self._unclean = keeper, read_levels, unclean
        self._records, self._drop = records, drop
        self._prover: SenderRole[Connection] = SenderRole(keeper.policy.fresh_us)

    def answer(self, connection: Connection, line: bytes) -> dict[str, Any] | None:
        """The reply to a message; None: it gets none."""
        number = None
        connection.heard_at = now_us()
        try:
            message = read_message(line)
            number = read_id(message)
            request = read_request(message)
            more = self._do(connection, request)
            self._records.keep(self._keeper)
            if request.op == "tell" and number is None:
                return None
        except ReportedError as error:
            return refusal(number, error) | {"levels": self._keeper.levels}
        except Exception:  # noqa: BLE001 the owner must outlive whatever a client sends
            _log.exception("a request of %s failed", connection.process)
            return refusal(number, ArbiterError("the line owner failed at this request; its log says why."))
        return {"id": number, "ok": True, "error": None, "levels": self._keeper.levels} | more

    def left(self, connection: Connection) -> None:
        """A connection has ended."""
        self._prover.leave(connection)

    def _do(self, connection: Connection, request: Request) -> dict[str, Any]:
        keeper, session, at = self._keeper, connection.session, now_us()
        match request.op:
            case "status":
                about = {"pid": os.getpid(), "unclean": self._unclean}
                return {"status": about | report(keeper, at)}
            case "levels":
                return {"levels": self._read_levels()}
            case "reset":
                _log.info("%s resets the faults", connection.process)
                keeper.reset(at, self._records.troubles())
                return {}
            case "hello":
                return self._hello(connection, request, at)
            case "tell":
                if not self._prover.says(connection, at):
                    raise ArbiterError(
                        f"say hello with the role {SENSORS} first: what others tell counts for nothing."
                    )
                keeper.sensed.tell(request.predicates, request.at_us, at)
                return {}
        if session is None:
            raise ArbiterError("say hello first.")
        match request.op:
            case "set":
                if request.until_us is not None and at > request.until_us:
                    raise ArbiterError("this write came too late and was not executed.")
                return {"delay_us": keeper.write(session, request.levels, request.will, at)}
            case "renew":
                keeper.renew(session, at)
                return {"faults": list(keeper.sensed.faults.values())}
            case "latch":
                keeper.sensed.keep(request.fault, request.why)
                return {}
        keeper.bye(session, request.will or (), at)
        connection.session = None
        return {}

    def _hello(self, connection: Connection, request: Request, at: int) -> dict[str, Any]:
        if connection.session or connection.proves:
            raise ArbiterError("this connection has said hello already.")
        if request.role == SENSORS:
            return self._prove(connection, request, at)
        session = connection.session = self._keeper.hello(
            request.client,
            request.token,
            request.lines,
            request.will or (),
            at,
            pid=connection.pid,
            program=connection.program,
        )
        return {"overtaken": session.declared_dead}

    def _prove(self, connection: Connection, request: Request, at: int) -> dict[str, Any]:
        try:
            before = self._prover.take(connection, connection.uid, request.token, connection.process, at)
        except SecondSenderError as error:
            if error.heard:
                self._keeper.sensed.latch(SECOND, f"{error.what[0].upper()}{error.what[1:]}")
                self._records.keep(self._keeper)
            raise
        connection.proves = True
        _log.info("%s (%s) says what the sensors show", request.client, connection.process)
        if before is not None:
            self._drop(before, "another connection says what the sensors show")
        return {}


def refusal(number: int | str | None, error: ReportedError) -> dict[str, Any]:
    """A reply that says why not; ``number`` None: it belongs to no request."""
    retry = {"retry_us": error.retry_us} if isinstance(error, LastWillRunsError) else {}
    return {"id": number, "ok": False, "error": str(error), "code": error.code, "levels": {}} | retry
