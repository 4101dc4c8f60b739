"""The client of the line arbiter, for a program that writes lines."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from end_effector_hal.arbiter.client._conversation import Conversation
from end_effector_hal.arbiter.protocol import LastWillRunsError, make_token
from end_effector_hal.errors import ArbiterError, ReportedError
from end_effector_hal.vocabulary import (
    NO_PART,
    LastWill,
    LastWillStep,
    WrittenPart,
    printable,
    read_last_will,
)
from end_effector_hal.wires import now_us

_log = logging.getLogger("end_effector_hal.arbiter")
RENEW_S = 0.25
NO_FIELDS: Mapping[str, object] = {}
Steps = Iterable[LastWillStep | Mapping[str, object]]
"""A last will as steps, or in its JSON form."""
VALID = 0.9
"""Share of the time-out within which a write may be executed, so that it is never executed after the client has given
up.
"""


class WriteResult(NamedTuple):
    """The reply to a write: the present levels of all lines, and µs until the write is applied (0: it is applied;
    IL-10).
    """

    levels: dict[str, bool]
    delay_us: int


class ArbiterClient:
    """Writes some lines through the arbiter; thread-safe. A thread renews the lease every 0.25 s.

    After a lost connection one call fails with ArbiterError, at the latest the next one: levels may have changed,
    because the arbiter may have executed the last will. Later calls work again as soon as the arbiter does. A client
    that only reads reconnects by itself.

    Args:
        socket_path: the socket of the arbiter.
        client: own name, for messages.
        lines: lines that it writes; none: it only reads.
        will: the last will until the first `set` leaves another.
        timeout_s: longest wait for a reply.
        patience_s: longest wait for an arbiter to appear, now.

    Raises:
        ArbiterError: there is no arbiter, or it does not answer.
        LineBusyError: another client writes one of the lines; the message names it.
    """

    def __init__(
        self,
        socket_path: str | Path,
        client: str,
        lines: Iterable[str] = (),
        *,
        will: Steps = (),
        timeout_s: float = 1.0,
        patience_s: float = 5.0,
    ) -> None:
        self._client, self._token, self._lines = client, make_token(), list(lines)
        self._will: LastWill = read_last_will(will)
        self._timeout_s = timeout_s
        self._alive: Callable[[], bool] = lambda: True
        self._on_lost: Callable[[ArbiterError], None] | None = None
        self._on_faults: Callable[[Mapping[str, str]], None] | None = None
        self._faults: dict[str, str] = {}  # as on_faults knows them
        self._latched: dict[str, str] = {}  # by this client
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._arbiter = Conversation(str(socket_path), timeout_s)
        self._lost: ArbiterError | None = None
        self._declared_dead = False
        self._connect_patiently(patience_s)
        self._thread = threading.Thread(
            target=self._renew_until_closed, name=f"lease of {client}", daemon=True
        )
        if self._lines:
            self._thread.start()

    def attend(
        self,
        *,
        alive: Callable[[], bool] = lambda: True,
        on_lost: Callable[[ArbiterError], None] | None = None,
        on_faults: Callable[[Mapping[str, str]], None] | None = None,
    ) -> None:
        """Set the callbacks of the thread that renews the lease.

        Args:
            alive: called before each renewal; while it returns False, the lease runs out and the last will is
                executed.
            on_lost: called when the thread finds the connection lost.
            on_faults: called with the latched faults, sentences by name, now (if there are any) and when they change.
        """
        with self._lock:
            self._alive, self._faults = alive, {}
            self._on_lost, self._on_faults = on_lost, on_faults
        if on_faults and self._lines and (lost := self._renew()) and on_lost:
            on_lost(lost)

    def levels(self) -> dict[str, bool]:
        """Return the levels of all lines of the arbiter, read back. They prove that the lines are written, not that an
        actuator moved.
        """
        return dict(self._call("levels")["levels"])

    def recorded_part(self) -> str:
        """Return the name of the part that was gripped last; empty: none, or it has no name."""
        return str(self._call("levels").get("part", ""))

    def declared_dead(self) -> bool:
        """Return whether, since the last call, the arbiter declared this client dead and executed its last will."""
        with self._lock:
            declared, self._declared_dead = self._declared_dead, False
        return declared

    def set(
        self,
        levels: Mapping[str, bool],
        will: Steps | None = None,
        *,
        drop: bool = False,
        part: WrittenPart = NO_PART,
    ) -> WriteResult:
        """Write some of the lines together.

        Args:
            levels: levels by line; True is active.
            will: the last will that the arbiter executes if this client dies from now on; None: unchanged.
            drop: a person asked for the deactivations; see `LineArbiter.write`.
            part: the part that is gripped; without a name: as before.

        Raises:
            LineRefusedError: an interlock refuses; the message begins with its id. Nothing has changed.
            ArbiterError: the arbiter is gone or does not answer; read the levels before any other call.
        """
        steps = None if will is None else read_last_will(will)
        with self._lock:
            if steps is not None and not levels:
                self._will = steps  # it changes no line: the next connection begins with it in any case
            self._raise_lost()
            if not self._arbiter.connected:
                self._connect()
            return self._written(steps, self._begin_set(levels, steps, drop=drop, part=part))

    def ask(
        self,
        levels: Mapping[str, bool],
        will: Sequence[LastWillStep] | None = None,
        *,
        drop: bool = False,
        part: WrittenPart = NO_PART,
    ) -> Callable[[], int]:
        """Do `set` in two parts: send now, without waiting; the returned function waits for the reply.

        Only the arbiter checks the last will here: the function raises UsageError if it is not valid.

        That function returns µs until this write and all before it are applied (0: they are; IL-10). It must be called
        exactly once, from any thread: until then all other calls of this client wait.
        """
        steps = None if will is None else tuple(will)
        locked = self._lock.acquire(blocking=False)
        if not locked or self._lost is not None or not self._arbiter.connected:
            if locked:
                self._lock.release()
            return lambda: self.set(levels, steps, drop=drop, part=part).delay_us
        try:
            failed = self._begin_set(levels, steps, drop=drop, part=part)
        except BaseException:  # what cannot be sent: nothing waits for its reply
            self._lock.release()
            raise

        def wait() -> int:
            try:
                return self._written(steps, failed).delay_us
            finally:
                self._lock.release()

        return wait

    def status(self) -> dict[str, Any]:
        """Return the arbiter's pid, its clients with lease and last will, and the activations that it ended (IL-03)."""
        return dict(self._call("status")["status"])

    def latch(self, fault: str, why: str) -> None:
        """Latch a fault that the arbiter's policy lists; `status` shows it, and the first ``why`` stays.

        While this client lives, only its `clear` ends the fault; after that a `reset` does. If the fault cannot be
        sent now, it is sent with the next connection.
        """
        why = printable(why)
        self._tell_faults("latch", {**self._latched, fault: why}, fault=fault, why=why)

    def clear(self, fault: str) -> None:
        """End a fault that this client has latched, after its own reset; sent like `latch`."""
        left = {name: why for name, why in self._latched.items() if name != fault}
        self._tell_faults("clear", left, fault=fault)

    def reset(self) -> dict[str, str]:
        """Clear the latched faults; return the faults of live clients that have not been reset, sentences by name.

        Raises:
            LineRefusedError: some faults stay because their cause persists; the message names them.
        """
        return {str(name): printable(str(why)) for name, why in self._call("reset").get("stays", {}).items()}

    def stop(self) -> None:
        """Latch a stop (IL-13): nothing is activated until `reset`."""
        self._call("stop")

    def close(self, will: Steps | None = None) -> None:
        """End the session in order: ``will`` is executed at once; None: the lines keep their levels.

        Raises:
            ArbiterError: ``will`` was given and could not be delivered.
        """
        if self._ended.is_set():
            return
        steps = read_last_will(will or ())
        self._ended.set()
        try:
            if self._lines:
                with (
                    self._lock
                ):  # also to a restarted arbiter, which would otherwise declare this client dead
                    self._request("bye", {"will": steps}, again=True)
        except ReportedError:
            if steps:
                raise
        finally:
            self._abandon()

    def __enter__(self) -> ArbiterClient:
        return self

    def __exit__(self, error: object, *_: object) -> None:
        if error is None:
            self.close()
        else:
            # No bye: an application that fails is dead, and its last will is executed.
            self._ended.set()
            self._abandon()

    def _abandon(self) -> None:
        if self._thread.is_alive() and self._thread is not threading.current_thread():
            self._thread.join()
        with self._lock:
            self._arbiter.close()

    def _renew_until_closed(self) -> None:
        while not self._ended.wait(RENEW_S):
            try:
                lost = self._renew() if self._alive() else None
                if lost and self._on_lost:
                    self._on_lost(lost)
            except Exception:  # noqa: BLE001 the application's
                _log.exception("a callback of the client %s failed", self._client)

    def _renew(self) -> ArbiterError | None:
        """Renew the lease; return the error if the connection was lost just now. Later failures to reconnect return
        None.
        """
        with self._lock:
            connected, known = self._arbiter.connected, self._faults
            try:
                if not self._ended.is_set():
                    found = self._request("renew").get("faults", {})
                    named = found.items() if isinstance(found, dict) else ()
                    self._faults = {printable(str(name)): printable(str(why)) for name, why in named}
            except ReportedError as error:
                if connected:
                    self._lost = error if isinstance(error, ArbiterError) else ArbiterError(str(error))
                    return self._lost
                return None
            faults, on_faults = self._faults, self._on_faults
        if on_faults and faults != known:
            on_faults(faults)
        return None

    def _call(self, op: str) -> dict[str, Any]:
        with self._lock:
            self._raise_lost()
            # the arbiter closes a connection that only reads when it is silent for a while
            return self._request(op, again=not self._lines)

    def _tell_faults(self, op: str, latched: Mapping[str, str], **fields: str) -> None:
        with self._lock:
            self._latched = dict(latched)
            try:
                self._request(op, fields)
            except ArbiterError as error:
                self._lost = error
                raise

    def _raise_lost(self) -> None:
        if self._lost is not None:
            lost, self._lost = self._lost, None
            raise lost

    def _begin_set(
        self, levels: Mapping[str, bool], will: LastWill | None, *, drop: bool, part: WrittenPart
    ) -> OSError | None:
        """Send the write; return the error if sending failed."""
        # this side gives up after the time-out: it must not be executed later
        until_us = now_us() + round(VALID * self._timeout_s * 1e6)
        fields: dict[str, object] = {"until_us": until_us, "levels": levels}
        if drop:
            fields["drop"] = True
        if part.name:
            fields["part"] = part.name
        if part.values:
            fields["values"] = part.values
        if will is not None:
            fields["will"] = will
        return self._arbiter.request("set", fields)

    def _written(self, will: LastWill | None, failed: OSError | None) -> WriteResult:
        try:
            reply = self._arbiter.reply(failed)
        except ArbiterError:
            # Perhaps it was executed: the next connection leaves the last will that goes with it.
            self._will = self._will if will is None else will
            raise
        self._will = self._will if will is None else will
        return WriteResult(reply["levels"], reply["delay_us"])

    def _connect_patiently(self, patience_s: float) -> None:
        until = time.monotonic() + patience_s
        while True:
            try:
                with self._lock:
                    return self._connect()
            except LastWillRunsError as error:
                # A last will certainly ends, so the patience does not limit this wait.
                wait_s = error.retry_us / 1e6 + 0.001
            except ArbiterError:
                wait_s = 0.05
                if time.monotonic() + wait_s > until:
                    raise
            self._ended.wait(wait_s)

    def _connect(self) -> None:
        self._arbiter.connect()
        if self._lines:
            try:
                named = {"client": self._client, "token": self._token, "lines": self._lines}
                reply = self._arbiter.exchange(
                    "hello", {**named, "will": self._will, "faults": self._latched}
                )
                self._declared_dead = self._declared_dead or bool(reply.get("overtaken"))
            except ReportedError:
                self._arbiter.close()
                raise

    def _request(
        self, op: str, fields: Mapping[str, object] = NO_FIELDS, *, again: bool = False
    ) -> dict[str, Any]:
        """Send a request; with ``again`` once more over a new connection, if the one that was open is lost."""
        again = again and self._arbiter.connected
        try:
            if not self._arbiter.connected:
                self._connect()
            return self._arbiter.exchange(op, fields)
        except ArbiterError:
            if not again or self._arbiter.connected:
                raise
        return self._request(op, fields)
