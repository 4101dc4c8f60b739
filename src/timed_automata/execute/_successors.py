"""What a discrete state leads to, worked out once: a controller is in the same few states again and again."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from timed_automata.compiler import Bound
from timed_automata.errors import RangeError
from timed_automata.execute._clocks import ClockInstants
from timed_automata.execute._observations import TakenEdge
from timed_automata.network import Change, Edge, Fired, Network, Semantics, State, Transition, changes_between

MOST = 2000
"""States that are remembered; after that many all is forgotten."""


@dataclass(eq=False)
class Successor:
    """A transition from a state, and what it leads to; nothing here depends on time.

    Attributes:
        transition, fired: an error if the update fails.
        kept: upper bounds of the clocks in the next state, of those that the transition does not set.
    """

    network: Network = field(repr=False)
    state: State
    transition: Transition
    fired: Fired | RangeError
    kept: tuple[Bound, ...] = ()

    @cached_property
    def edges(self) -> tuple[TakenEdge, ...]:
        """The participants, by their names."""
        return tuple(_taken(self.network, edge) for edge in self.transition.edges)

    @cached_property
    def changes(self) -> tuple[Change, ...]:
        """What it does to the variables."""
        assert isinstance(self.fired, Fired)
        return changes_between(self.network, self.state, self.fired.state)

    def window(self, clocks: ClockInstants, expired: Collection[Bound] = ()) -> tuple[int, int]:
        """The first and the last instant, µs, at which its guards and the invariants that it leads to allow it.

        ``expired`` are invariants that count no more: they are broken already.
        """
        first, last = clocks.window(self.transition.bounds)
        kept = [bound for bound in self.kept if bound not in expired] if expired else self.kept
        return first, min(last, clocks.window(kept)[1])


@dataclass(frozen=True, eq=False, slots=True)
class StateSuccessors:
    """The transitions out of one state.

    Attributes:
        successors: in the order in which those due at the same instant are taken.
        stay: upper bounds of the clocks in this state.
        may_delay: whether time may pass.
        committed: whether a process is in a committed location.
    """

    successors: tuple[Successor, ...]
    stay: tuple[Bound, ...]
    may_delay: bool
    committed: bool


class SuccessorCache:
    """Remembers them; the semantics says what they are."""

    def __init__(self, semantics: Semantics) -> None:
        self._semantics = semantics
        self._known: dict[State, StateSuccessors] = {}
        self._received: dict[tuple[State, int, tuple[tuple[int, int], ...]], Successor | None] = {}

    def at(self, state: State) -> StateSuccessors:
        """The successors of a state; raises RangeError where a guard fails."""
        known = self._known.get(state)
        if known is None:
            semantics = self._semantics
            successors = (self._successor(state, transition) for transition in semantics.transitions(state))
            known = StateSuccessors(
                tuple(each for each in successors if each is not None),
                tuple(semantics.invariant(state)),
                semantics.may_delay(state),
                semantics.committed(state),
            )
            if len(self._known) >= MOST:
                self._known.clear()
            self._known[state] = known
        return known

    def received(self, state: State, channel: int, writes: Mapping[int, int]) -> Successor | None:
        """What a broadcast of the environment, which writes by offset, leads to; None: no edge receives it.

        Raises:
            RangeError: an assignment is out of range.
        """
        key = (state, channel, tuple(writes.items()))
        if key in self._received:
            return self._received[key]
        transition = next(self._semantics.received(state, channel), None)
        found = None
        if transition is not None and transition.edges:
            fired = self._semantics.fire(state, transition.edges, writes)
            found = Successor(self._semantics.network, state, transition, fired)
        if len(self._received) >= MOST:
            self._received.clear()
        self._received[key] = found
        return found

    def _successor(self, state: State, transition: Transition) -> Successor | None:
        """None: it would break an invariant, whatever the time is."""
        network = self._semantics.network
        try:
            fired = self._semantics.fire(state, transition.edges)
            if not self._semantics.allowed(fired.state):
                return None
            invariant = self._semantics.invariant(fired.state)
        except RangeError as error:  # raised when the edge is taken, if ever
            return Successor(network, state, transition, error)
        values = dict(fired.resets)
        if not all(_holds(values[bound.clock], bound) for bound in invariant if bound.clock in values):
            return None
        kept = tuple(bound for bound in invariant if bound.clock not in values)
        return Successor(network, state, transition, fired, kept)


def _holds(value: int, bound: Bound) -> bool:
    return value < bound.value or (value == bound.value and bound.op == "<=")


def _taken(network: Network, edge: Edge) -> TakenEdge:
    process = network.processes[edge.process]
    source, target = process.locations[edge.source], process.locations[edge.target]
    return TakenEdge(process.name, source.name, target.name, edge.index, edge.span.where)
