"""The client of the line owner, for whoever writes lines."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from end_effector_hal.arbiter.client._conversation import Conversation, WillStillRunsError
from end_effector_hal.arbiter.protocol import make_token
from end_effector_hal.errors import ArbiterError, ReportedError
from end_effector_hal.vocabulary import LastWill, LastWillStep, printable, read_last_will
from end_effector_hal.wires import now_us

_log = logging.getLogger("end_effector_hal.arbiter")
RENEW_S = 0.25
VALID = 0.9
"""Share of the time-out during which a write may be executed: never once it was given up."""


class WriteResult(NamedTuple):
    """What became of a write: the levels of all lines now, and µs until it is applied (0: it is; IL-10)."""

    levels: dict[str, bool]
    delay_us: int


class ArbiterClient:
    """Writes some lines through the owner; thread-safe. A thread renews the lease, every 0.25 s.

    When the connection is lost, one call fails with ArbiterError, at the latest the next one: levels may have
    changed, for the owner may have executed the will. The calls after it work again, once the owner does. A client
    that reads only connects again by itself.

    Args:
        socket_path: of the owner.
        client: own name, as others are told it.
        lines: that it writes; none: it reads only.
        will: until the first `set` leaves another.
        timeout_s: longest wait for a reply.
        patience_s: how long to wait for an owner to appear, now.

    Raises:
        ArbiterError: there is no owner, or it does not answer.
        LineBusyError: another client writes one of the lines; says who.
    """

    def __init__(
        self,
        socket_path: str | Path,
        client: str,
        lines: Iterable[str] = (),
        *,
        will: Iterable[LastWillStep | Mapping[str, object]] = (),
        timeout_s: float = 1.0,
        patience_s: float = 5.0,
    ) -> None:
        self._client, self._token, self._lines = client, make_token(), list(lines)
        self._will: LastWill = read_last_will(will)
        self._timeout_s = timeout_s
        self._alive: Callable[[], bool] = lambda: True
        self._on_lost: Callable[[ArbiterError], None] = _nobody
        self._on_faults: Callable[[tuple[str, ...]], None] = _nobody
        self._faults: tuple[str, ...] = ()  # as on_faults knows them
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._owner = Conversation(str(socket_path), timeout_s)
        self._lost: ArbiterError | None = None
        self._declared_dead = False
        self._connect_patiently(patience_s)
        self._thread = threading.Thread(target=self._renew_for_ever, name=f"lease of {client}", daemon=True)
        if self._lines:
            self._thread.start()

    def attend(
        self,
        *,
        alive: Callable[[], bool] = lambda: True,
        on_lost: Callable[[ArbiterError], None] | None = None,
        on_faults: Callable[[tuple[str, ...]], None] | None = None,
    ) -> None:
        """Whom the thread of the renewals asks and tells, from now on.

        Args:
            alive: asked before each renewal; a program that hangs loses its lease, and its will is done.
            on_lost: called when that is where the loss of the connection is seen.
            on_faults: called when the owner has latched others than it knows of, sentences; at first it knows none.
        """
        with self._lock:
            self._alive, self._faults = alive, ()
            self._on_lost, self._on_faults = on_lost or _nobody, on_faults or _nobody

    def levels(self) -> dict[str, bool]:
        """Of all lines of the owner, read back: they prove the claim, not the actuator."""
        return dict(self._call("levels")["levels"])

    def declared_dead(self) -> bool:
        """Whether the owner took this client for dead, and did its will, since this was asked last."""
        with self._lock:
            told, self._declared_dead = self._declared_dead, False
        return told

    def set(
        self, levels: Mapping[str, bool], will: Iterable[LastWillStep | Mapping[str, object]] | None = None
    ) -> WriteResult:
        """Write some of the lines, at once.

        Args:
            levels: True is active.
            will: what the owner does should this client die from now on; None: as before.

        Raises:
            LineRefusedError: an interlock refuses, its id first in the sentence; nothing has changed.
            ArbiterError: the owner is gone or does not answer; read the levels before anything else.
        """
        steps = None if will is None else read_last_will(will)
        with self._lock:
            self._raise_lost()
            if not self._owner.connected:
                self._connect()
            return self._written(steps, self._begin_set(levels, steps))

    def ask(
        self, levels: Mapping[str, bool], will: Iterable[LastWillStep | Mapping[str, object]] | None = None
    ) -> Callable[[], WriteResult]:
        """As `set`, in two parts: it is sent, if that can be done at once; what is returned waits for the reply.

        It never waits itself. What is returned must be called, once, in any thread: all others wait for that.
        """
        steps = None if will is None else read_last_will(will)
        if not self._lock.acquire(blocking=False):
            return lambda: self.set(levels, steps)
        if self._lost is not None or not self._owner.connected:
            self._lock.release()
            return lambda: self.set(levels, steps)
        failed = self._begin_set(levels, steps)

        def wait() -> WriteResult:
            try:
                return self._written(steps, failed)
            finally:
                self._lock.release()

        return wait

    def status(self) -> dict[str, Any]:
        """The owner's pid, clients with lease and will, and the activations that it ended (IL-03)."""
        return dict(self._call("status")["status"])

    def latch(self, fault: str, why: str) -> None:
        """Keep a fault that the owner's policy lists until `reset`; it shows in `status`, the first ``why`` stays."""
        self._call("latch", fault=fault, why=why)

    def reset(self) -> None:
        """Clear all latched faults.

        Raises:
            LineRefusedError: some still are the case and stay; says which.
        """
        self._call("reset")

    def close(self, will: Iterable[LastWillStep | Mapping[str, object]] | None = None) -> None:
        """Leave in order: ``will`` is executed at once; none: the lines stay as they are.

        Raises:
            ArbiterError: ``will`` was given and could not be delivered.
        """
        if self._ended.is_set():
            return
        steps = read_last_will(will or ())
        self._ended.set()
        try:
            if self._lines:
                self._say_bye(steps)
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
            # No bye: an application that fails is dead, its will counts.
            self._ended.set()
            self._abandon()

    def _say_bye(self, will: LastWill) -> None:
        """Also to an owner that has followed the one it knew: without a bye that would take this for a death."""
        fields = {"will": [step.as_json() for step in will]}
        with self._lock:
            was_connected = self._owner.connected
            try:
                self._request("bye", **fields)
            except ArbiterError:
                if not was_connected:
                    raise
                self._request("bye", **fields)

    def _abandon(self) -> None:
        if self._thread.is_alive() and self._thread is not threading.current_thread():
            self._thread.join()
        with self._lock:
            self._owner.close()

    def _renew_for_ever(self) -> None:
        while not self._ended.wait(RENEW_S):
            try:
                if self._alive() and (lost := self._renew()):
                    self._on_lost(lost)
            except Exception:  # noqa: BLE001 the application's
                _log.exception("a callback of the client %s failed", self._client)

    def _renew(self) -> ArbiterError | None:
        """The error if the connection was lost just now; later failures to come back are no news."""
        with self._lock:
            connected, known = self._owner.connected, self._faults
            try:
                if not self._ended.is_set():
                    self._faults = tuple(
                        printable(str(why)) for why in self._request("renew").get("faults", ())
                    )
            except ReportedError as error:
                if connected:
                    self._lost = error if isinstance(error, ArbiterError) else ArbiterError(str(error))
                    return self._lost
                return None
            faults, tell = self._faults, self._on_faults
        if faults != known:
            tell(faults)
        return None

    def _call(self, op: str, **fields: object) -> dict[str, Any]:
        with self._lock:
            self._raise_lost()
            again = self._owner.connected and not self._lines
            try:
                return self._request(op, **fields)
            except ArbiterError:
                # one that only reads is closed when it said nothing for a while
                if not again or self._owner.connected:
                    raise
                return self._request(op, **fields)

    def _raise_lost(self) -> None:
        if self._lost is not None:
            lost, self._lost = self._lost, None
            raise lost

    def _begin_set(self, levels: Mapping[str, bool], will: LastWill | None) -> OSError | None:
        """Sends it; the error, if it could not be."""
        fields: dict[str, object] = {"levels": {line: bool(level) for line, level in levels.items()}}
        # given up after the time-out: not to be executed later
        fields["until_us"] = now_us() + round(VALID * self._timeout_s * 1e6)
        if will is not None:
            fields["will"] = [step.as_json() for step in will]
        return self._owner.send("set", fields)

    def _written(self, will: LastWill | None, failed: OSError | None) -> WriteResult:
        try:
            reply = self._owner.reply(failed)
        except ArbiterError:
            # Perhaps it was executed: whoever connects again leaves the will that goes with it.
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
            except WillStillRunsError as error:
                # The end of a will is certain, so it is waited for whatever the patience.
                wait_s = error.retry_s + 0.001
            except ArbiterError:
                wait_s = 0.05
                if time.monotonic() + wait_s > until:
                    raise
            self._ended.wait(wait_s)

    def _connect(self) -> None:
        self._owner.connect()
        if self._lines:
            try:
                will = [step.as_json() for step in self._will]
                named = {"client": self._client, "token": self._token}
                said = self._owner.exchange("hello", {**named, "lines": self._lines, "will": will})
                self._declared_dead = self._declared_dead or bool(said.get("overtaken"))
            except ReportedError:
                self._owner.close()
                raise

    def _request(self, op: str, **fields: object) -> dict[str, Any]:
        if not self._owner.connected:
            self._connect()
        return self._owner.exchange(op, fields)


def _nobody(_: object) -> None:
    """Is told nothing."""
