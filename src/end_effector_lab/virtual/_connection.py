"""The program's connection to the line arbiter in virtual time; replaces the socket of an `ArbiterClient`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NoReturn, TypeVar

from end_effector_hal.arbiter.rules import Session
from end_effector_hal.errors import ArbiterError, ReportedError
from end_effector_hal.vocabulary import NO_PART, LastWillStep, WrittenPart, printable, read_last_will

from ._arbiter import VirtualArbiter

T = TypeVar("T")
RENEW_US = 250_000


class VirtualConnection:
    """A connection whose messages are answered at once. After the death of the arbiter one call fails, and the next
    one reconnects.

    Args:
        arbiter: returns the living arbiter; None: there is none.
        client: its name.
        token: identifies the program when it reconnects.
        lines: the lines that it writes.
        clock: returns the time, µs.
    """

    def __init__(
        self,
        arbiter: Callable[[], VirtualArbiter | None],
        client: str,
        token: str,
        lines: Sequence[str],
        clock: Callable[[], int],
    ) -> None:
        self._living, self._client, self._token = arbiter, client, token
        self._lines, self._clock = tuple(lines), clock
        self._arbiter: VirtualArbiter | None = None
        self._session: Session | None = None
        self._will: tuple[LastWillStep, ...] = ()
        self._lost: ArbiterError | None = None
        self._declared_dead = False
        self._faults: dict[str, str] = {}
        self._latched: dict[str, str] = {}
        self.renews_at = clock() + RENEW_US
        """Time at which `renew` must be called, µs."""
        self._connect()

    def levels(self) -> Mapping[str, bool]:
        """Return the levels of all lines, read back."""
        return self._call(lambda arbiter, _: arbiter.rules.read_levels())

    def recorded_part(self) -> str:
        """Return the name of the part that was gripped last; empty: none, or it has no name."""
        return self._call(lambda arbiter, _: arbiter.rules.part)

    def declared_dead(self) -> bool:
        """Return whether the arbiter has declared this program dead since the last call."""
        declared, self._declared_dead = self._declared_dead, False
        return declared

    def ask(
        self,
        levels: Mapping[str, bool],
        will: Sequence[LastWillStep],
        *,
        drop: bool = False,
        part: WrittenPart = NO_PART,
    ) -> Callable[[], int]:
        """Write levels; the returned function returns the delay in µs until they are applied, or raises."""
        steps = read_last_will(will)

        def written(arbiter: VirtualArbiter, session: Session) -> int:
            return arbiter.rules.write(session, levels, steps, self._clock(), drop=drop, part=part)

        try:
            delay_us = self._call(written)
            self._will = steps
        except ReportedError as error:
            return _raising(error)
        return lambda: delay_us

    def status(self) -> dict[str, Any]:
        """Return the latched faults."""
        return self._call(lambda arbiter, _: {"faults": dict(arbiter.rules.predicates.faults)})

    def latch(self, fault: str, why: str) -> None:
        """Latch a fault."""
        self._latched[fault] = why
        self._tell_fault(lambda arbiter, session: arbiter.rules.latch(session, fault, why))

    def clear(self, fault: str) -> None:
        """Clear a fault that this program has latched."""
        self._latched.pop(fault, None)
        self._tell_fault(lambda arbiter, session: arbiter.rules.clear(session, fault))

    def renew(self) -> tuple[ArbiterError | None, dict[str, str] | None]:
        """Renew the lease; return why the connection was just lost, and the faults if they have changed."""
        self.renews_at = self._clock() + RENEW_US
        known = self._session is not None
        try:
            faults = self._exchange(self._renewed)
        except ReportedError as error:
            if not known:
                return None, None
            self._lost = error if isinstance(error, ArbiterError) else ArbiterError(str(error))
            return self._lost, None
        changed, self._faults = faults != self._faults, faults
        return None, faults if changed else None

    def close(self, will: Sequence[LastWillStep]) -> None:
        """Leave properly; raises ArbiterError if the last will could not be delivered."""
        steps = read_last_will(will)
        self._exchange(lambda arbiter, session: arbiter.rules.bye(session, steps, self._clock()))
        self._session = None

    def die(self) -> None:
        """Close the socket of the dead process."""
        arbiter, session, self._session = self._living(), self._session, None
        if arbiter is not None and arbiter is self._arbiter and session is not None and not session.ended:
            arbiter.rules.declare_dead(session, "its socket was closed", self._clock())
            arbiter.keep()

    def _renewed(self, arbiter: VirtualArbiter, session: Session) -> dict[str, str]:
        arbiter.rules.renew(session, self._clock())
        faults = arbiter.rules.predicates.faults
        return {printable(name): printable(why) for name, why in faults.items()}

    def _tell_fault(self, what: Callable[[VirtualArbiter, Session], None]) -> None:
        try:
            self._exchange(what)
        except ArbiterError as error:
            self._lost = error
            raise

    def _call(self, what: Callable[[VirtualArbiter, Session], T]) -> T:
        if self._lost is not None:
            lost, self._lost = self._lost, None
            raise lost
        return self._exchange(what)

    def _exchange(self, what: Callable[[VirtualArbiter, Session], T]) -> T:
        if self._session is not None and (self._arbiter is not self._living() or self._session.ended):
            self._session = None
            raise ArbiterError("the line arbiter has closed the connection.")
        if self._session is None:
            self._connect()
        arbiter, session = self._arbiter, self._session
        assert arbiter is not None
        assert session is not None
        try:
            return what(arbiter, session)
        finally:
            arbiter.keep()

    def _connect(self) -> None:
        arbiter = self._living()
        if arbiter is None:
            raise ArbiterError("the line arbiter cannot be reached.", todo="Start it.")
        try:
            session = arbiter.rules.hello(
                self._client, self._token, self._lines, self._will, self._clock(), faults=self._latched
            )
        finally:
            arbiter.keep()
        self._arbiter, self._session = arbiter, session
        self._declared_dead = self._declared_dead or session.declared_dead


def _raising(error: ReportedError) -> Callable[[], NoReturn]:
    def fail() -> NoReturn:
        raise error

    return fail
