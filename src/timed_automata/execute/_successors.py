"""Caches the successors of discrete states, because a controller is in the same few states again and again.

Clocks are stored as the instants at which they were zero; a successor is possible in windows of time.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from timed_automata.compiler import Bound
from timed_automata.errors import RangeError
from timed_automata.execute._observations import TakenEdge
from timed_automata.network import Change, Edge, Fired, Semantics, State, Transition, changes_between

ALWAYS, NEVER = -(1 << 62), 1 << 62


class ClockInstants:
    """Clocks stored as instants: a clock with value ``c`` at time ``t`` was, or would have been, zero at ``t - c``."""

    def __init__(self, count: int, unit_us: int) -> None:
        self._zero = [0] * count
        self._unit = unit_us

    def start(self, at: int) -> None:
        """Set all clocks to zero at ``at``."""
        self._zero = [at] * len(self._zero)

    @property
    def zeros(self) -> list[int]:
        """The instant at which each clock was zero, by clock number."""
        return list(self._zero)

    def resume(self, zeros: list[int]) -> None:
        """Restore the clocks from the instants at which they were zero."""
        self._zero = list(zeros)

    def set(self, resets: Iterable[tuple[int, int]], at: int) -> None:
        """Set clocks to values, given in the model's unit of time."""
        for clock, value in resets:
            self._zero[clock] = at - value * self._unit

    def copy(self) -> ClockInstants:
        """Return clocks with the same instants."""
        new = ClockInstants(0, self._unit)
        new._zero = list(self._zero)
        return new

    def instants(self, bounds: Iterable[Bound], now: int) -> list[int]:
        """Return the instants after ``now`` at which constraints on clocks that were zero before change."""
        zero, unit = self._zero, self._unit
        found = [zero[clock] + value * unit for clock, _, value in bounds if zero[clock] < now]
        return [instant for instant in found if instant >= now]

    def window(self, bounds: Iterable[Bound]) -> tuple[int, int]:
        """Return the first and the last instant, in whole µs, at which a conjunction of constraints holds."""
        first, last = ALWAYS, NEVER
        for clock, op, value in bounds:
            instant = self._zero[clock] + value * self._unit
            if op in (">=", ">", "=="):
                first = max(first, instant + (op == ">"))
            if op in ("<=", "<", "=="):
                last = min(last, instant - (op == "<"))
        return first, last


MOST = 4000
"""Largest number of cached states; a full cache is cleared."""
Received = tuple[State, int, tuple[tuple[int, int], ...]]
"""A state, the number of a channel, and the values that the sender writes, by offset."""


@dataclass(eq=False, slots=True)
class Successor:
    """A transition from a state and its result; both are independent of time.

    Attributes:
        transition: the transition.
        fired: its result, or an error if the update fails.
        edges: the edges of the participants, with names.
        changes: changes of variables; empty if the update fails.
        sent: the name of the channel on which an executed process sends.
        kept: bounds in the next state on clocks that the transition does not set.
        bounds: its own bounds and ``kept``; empty: no clock restricts when it may be taken.
    """

    transition: Transition
    fired: Fired | RangeError
    edges: tuple[TakenEdge, ...] = field(repr=False)
    changes: tuple[Change, ...] = field(repr=False)
    sent: str | None = None
    kept: tuple[Bound, ...] = ()
    bounds: tuple[Bound, ...] = field(init=False)

    def __post_init__(self) -> None:
        self.bounds = (*self.transition.bounds, *self.kept)

    def bounds_without(self, expired: Collection[Bound]) -> tuple[Bound, ...]:
        """Return its bounds without the invariants that no longer count because they are violated already."""
        return (*self.transition.bounds, *[bound for bound in self.kept if bound not in expired])


@dataclass(frozen=True, eq=False, slots=True)
class StateSuccessors:
    """The transitions out of one state.

    Attributes:
        successors: in the order in which those due at the same instant are taken.
        stay: bounds that the invariants put on the clocks in this state.
        may_delay: whether time may pass.
        committed: whether a process is in a committed location.
    """

    successors: tuple[Successor, ...]
    stay: tuple[Bound, ...]
    may_delay: bool
    committed: bool

    @property
    def bounds(self) -> Iterator[Bound]:
        """All bounds on clocks that decide when the state is left."""
        yield from self.stay
        for successor in self.successors:
            yield from successor.bounds


class SuccessorCache:
    """Caches the successors that the semantics computes. Several executions may share one cache, also in several
    threads.
    """

    def __init__(self, semantics: Semantics) -> None:
        self._semantics = semantics
        self.known: dict[State, StateSuccessors] = {}
        """The results of `at` so far."""
        self._received: dict[Received, Successor | None] = {}
        self._named: dict[Edge, TakenEdge] = {}

    def at(self, state: State) -> StateSuccessors:
        """Return the successors of a state; raise RangeError if a guard fails."""
        known = self.known.get(state)
        if known is None:
            semantics = self._semantics
            successors = (self._successor(state, transition) for transition in semantics.transitions(state))
            known = StateSuccessors(
                tuple(each for each in successors if each is not None),
                tuple(semantics.invariant(state)),
                semantics.may_delay(state),
                semantics.committed(state),
            )
            if len(self.known) >= MOST:
                self.known.clear()
            self.known[state] = known
        return known

    def received(self, state: State, channel: int, writes: Mapping[int, int]) -> Successor | None:
        """Return the result of a broadcast of the environment that writes by offset; None if no edge receives it.

        Raises:
            RangeError: an assignment is out of range.
        """
        key = (state, channel, tuple(writes.items()))
        try:
            return self._received[key]
        except KeyError:
            found = self._work_out(state, channel, writes)
        if len(self._received) >= MOST:
            self._received.clear()
        self._received[key] = found
        return found

    def _work_out(self, state: State, channel: int, writes: Mapping[int, int]) -> Successor | None:
        transition = next(self._semantics.received(state, channel), None)
        if transition is None or not transition.edges:
            return None
        fired = self._semantics.fire(state, transition.edges, writes)
        return self._made(state, transition, fired)

    def _successor(self, state: State, transition: Transition) -> Successor | None:
        """Return the successor, or None if the transition would violate an invariant at any time."""
        try:
            fired = self._semantics.fire(state, transition.edges)
            if not self._semantics.allowed(fired.state):
                return None
            invariant = self._semantics.invariant(fired.state)
        except RangeError as error:  # raised when the edge is taken, if ever
            return self._made(state, transition, error)
        values = dict(fired.resets)
        if not all(bound.allows(values[bound.clock]) for bound in invariant if bound.clock in values):
            return None
        kept = tuple(bound for bound in invariant if bound.clock not in values)
        return self._made(state, transition, fired, kept)

    def _made(
        self,
        state: State,
        transition: Transition,
        fired: Fired | RangeError,
        kept: tuple[Bound, ...] = (),
    ) -> Successor:
        network = self._semantics.network
        return Successor(
            transition,
            fired,
            tuple([self._named.get(edge) or self._name(edge) for edge in transition.edges]),
            changes_between(network, state, fired.state) if isinstance(fired, Fired) else (),
            None if transition.channel is None else network.channels[transition.channel].name,
            kept,
        )

    def _name(self, edge: Edge) -> TakenEdge:
        process = self._semantics.network.processes[edge.process]
        source, target = process.locations[edge.source], process.locations[edge.target]
        named = TakenEdge(process.name, source.name, target.name, edge.index, edge.span.where)
        self._named[edge] = named
        return named
