"""Executes the requests to the line arbiter and builds the replies."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable
from functools import lru_cache
from typing import Any

from end_effector_hal.arbiter.protocol import (
    HEAD,
    LONGEST_KEPT,
    MOST_KEPT,
    SENSORS,
    LastWillRunsError,
    Request,
    read_id,
    read_message,
    read_request,
    read_rest,
)
from end_effector_hal.arbiter.records import Records
from end_effector_hal.arbiter.rules._arbiter import LineArbiter
from end_effector_hal.arbiter.rules._predicates import CLOCKS, SKEW_US
from end_effector_hal.arbiter.rules._sender_role import SecondSenderError, SenderRole
from end_effector_hal.arbiter.server._connections import Connection
from end_effector_hal.errors import ArbiterError, ReportedError
from end_effector_hal.wires import now_us

_log = logging.getLogger("end_effector_hal.arbiter")
READS = frozenset({"tell", "renew", "status"})
"""Requests after which the records are still valid, unless a predicate has latched a fault."""
SECOND = "sensors"
"""Name of the fault that a second process claims to read the sensors."""


class RequestHandler:
    """Executes requests and builds the replies.

    Args:
        arbiter: the rules of the lines.
        records: saved before each reply, so that the next arbiter has all that a client was promised.
        drop: closes a connection for the given reason.
    """

    def __init__(
        self, arbiter: LineArbiter, records: Records, drop: Callable[[Connection, str], None]
    ) -> None:
        self._arbiter, self._records, self._drop = arbiter, records, drop
        self._sender_role: SenderRole[Connection] = SenderRole(arbiter.policy.fresh_us)
        self._read_once = lru_cache(MOST_KEPT)(read_rest)

    def handle(self, connection: Connection, line: bytes) -> dict[str, Any] | None:
        """Execute a message and return the reply; None: the message gets no reply."""
        arbiter = self._arbiter
        number: int | str | None = None
        time_us: int | None
        connection.heard_at = at = now_us()
        try:
            head, request = HEAD.match(line), None
            if head and len(line) <= LONGEST_KEPT:
                request = self._read_once(head[2], line[head.end() :])
            if head and request:
                number, time_us = int(head[1]) if head[1] else None, int(head[3])
            else:
                message = read_message(line)
                number = read_id(message)
                request = read_request(message)
                time_us = request.time_us
            more = self._execute(connection, request, time_us, at)
            if request.op not in READS or arbiter.predicates.faults != self._records.faults:
                arbiter.written(now_us())
                self._records.keep(arbiter)
            if request.op == "tell" and number is None:
                return None
        except ReportedError as error:
            return refusal(number, error) | {"levels": arbiter.levels}
        except Exception:  # noqa: BLE001 the arbiter must outlive any message of a client
            _log.exception("a request of %s failed", connection.process)
            failed = ArbiterError("the line arbiter failed at this request; see its log.")
            return refusal(number, failed)
        return {"id": number, "ok": True, "error": None, "levels": arbiter.levels} | more

    def left(self, connection: Connection) -> None:
        """Free the role of a connection that has ended."""
        self._sender_role.leave(connection)

    def _execute(
        self, connection: Connection, request: Request, time_us: int | None, at: int
    ) -> dict[str, Any]:
        arbiter, session = self._arbiter, connection.session
        match request.op:
            case "tell":
                if not self._sender_role.accepts(connection, at):
                    raise ArbiterError(
                        f"only the connection with the role {SENSORS} may report predicates: say hello with it first."
                    )
                arbiter.predicates.update(request.predicates, time_us or 0, at)
                return {}
            case "status":
                about = {"pid": os.getpid(), "unclean": not self._records.before.clean}
                return {"status": about | status_report(arbiter, at)}
            case "levels":
                part = {"part": arbiter.part} if arbiter.part else {}
                return {"levels": arbiter.read_levels(), **part}
            case "reset":
                _log.info("%s resets the faults", connection.process)
                return {"stays": arbiter.reset(at, self._records.troubles())}
            case "stop":
                _log.warning("%s stops the tool", connection.process)
                arbiter.stop(connection.process)
                return {}
            case "hello":
                return self._hello(connection, request, at)
        if session is None:
            raise ArbiterError("say hello first.")
        match request.op:
            case "set":
                if time_us is not None and at > time_us:
                    why = f" ({CLOCKS})" if at - time_us >= SKEW_US else ""
                    raise ArbiterError(f"this write came too late and was not executed{why}.")
                delay_us = arbiter.write(
                    session, request.levels, request.will, at, drop=request.drop, part=request.part
                )
                return {"delay_us": delay_us}
            case "renew":
                arbiter.renew(session, at)
                return {"faults": dict(arbiter.predicates.faults)}
            case "latch":
                arbiter.latch(session, request.fault, request.why)
            case "clear":
                arbiter.clear(session, request.fault)
            case _:
                arbiter.bye(session, request.will or (), at)
                connection.session = None
        return {}

    def _hello(self, connection: Connection, request: Request, at: int) -> dict[str, Any]:
        if connection.session or connection.sends_predicates:
            raise ArbiterError("this connection has said hello already.")
        if request.role == SENSORS:
            return self._assign_role(connection, request, at)
        session = connection.session = self._arbiter.hello(
            request.client,
            request.token,
            request.lines,
            request.will or (),
            at,
            pid=connection.pid,
            program=connection.program,
            faults=request.faults,
        )
        return {"overtaken": session.declared_dead}

    def _assign_role(self, connection: Connection, request: Request, at: int) -> dict[str, Any]:
        role, process = self._sender_role, connection.process
        try:
            before = role.assign(connection, connection.uid, request.token, process, at)
        except SecondSenderError as error:
            if error.active:
                self._arbiter.predicates.latch(SECOND, f"{error.what[0].upper()}{error.what[1:]}")
                self._records.keep(self._arbiter)
            raise
        connection.sends_predicates = True
        _log.info("%s (%s) reports what the sensors show", request.client, process)
        if before is not None:
            self._drop(before, "another connection reports what the sensors show")
        return {}


def refusal(number: int | str | None, error: ReportedError) -> dict[str, Any]:
    """Return a reply that gives the reason of a refusal; ``number`` None: the reply belongs to no request."""
    retry = {"retry_us": error.retry_us} if isinstance(error, LastWillRunsError) else {}
    return {"id": number, "ok": False, "error": str(error), "code": error.code, "levels": {}} | retry


def status_report(arbiter: LineArbiter, at: int) -> dict[str, Any]:
    """Return the clients with their lines, the reported predicates and the latched faults, at ``at`` µs."""
    needs = (need for needs in arbiter.policy.needs.values() for need in needs)
    return {
        "lines": list(arbiter.policy.lines),
        "may_be_active": arbiter.may_be_active,
        "clients": [
            {
                "client": session.client,
                "pid": session.pid,
                "lines": sorted(session.lines),
                "ended": session.ended,
                "absent": session.absent,
                "waiting": len(session.queue),
                "lease_us": max(0, session.lease_until - at),
                "will": [step.as_json() for step in session.will],
            }
            for session in arbiter.sessions
        ],
        "trips": [
            {"at": when, "line": line, "interlock": arbiter.policy.bounded_by(line)}
            for when, line in arbiter.trips
        ],
        "roles": {line: role.words for line, role in arbiter.policy.roles.items()},
        "needs": sorted({need.predicate for need in needs}),
        "told": {
            name: {"holds": proof.holds, "age_us": at - proof.at}
            for name, proof in arbiter.predicates.proofs.items()
        },
        "faults": dict(arbiter.predicates.faults),
    }
