"""What a discrete state leads to, worked out once: a controller is in the same few states again and again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from timed_automata._constraints import Bound
from timed_automata._network import Edge, Network, State
from timed_automata._semantics import Fired, Semantics, Transition
from timed_automata._steps import Change, TakenEdge
from timed_automata.errors import RangeError

MOST = 2000
"""States that are remembered; after that many all is forgotten."""


@dataclass(eq=False)
class Prospect:
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
        """The participants, as they are told."""
        return tuple(_told(self.network, edge) for edge in self.transition.edges)

    @cached_property
    def changes(self) -> tuple[Change, ...]:
        """What it does to the variables."""
        assert isinstance(self.fired, Fired)
        pairs = zip(self.network.offsets, self.state.values, self.fired.state.values, strict=True)
        return tuple(Change(name, before, after) for name, before, after in pairs if before != after)


@dataclass(frozen=True, eq=False, slots=True)
class Outlook:
    """Of one state.

    Attributes:
        prospects: in the order in which those due at the same instant are taken.
        stay: upper bounds of the clocks in this state.
        may_delay: whether time may pass.
        committed: whether a process is in a committed location.
    """

    prospects: tuple[Prospect, ...]
    stay: tuple[Bound, ...]
    may_delay: bool
    committed: bool


class Outlooks:
    """Remembers them; the semantics says what they are."""

    def __init__(self, semantics: Semantics) -> None:
        self._semantics = semantics
        self._known: dict[State, Outlook] = {}
        self._heard: dict[tuple[State, int, tuple[tuple[int, int], ...]], Prospect | None] = {}

    def at(self, state: State) -> Outlook:
        """Of a state; raises RangeError where a guard fails."""
        known = self._known.get(state)
        if known is None:
            semantics = self._semantics
            prospects = (self._prospect(state, transition) for transition in semantics.transitions(state))
            known = Outlook(
                tuple(each for each in prospects if each is not None),
                tuple(semantics.invariant(state)),
                semantics.may_delay(state),
                semantics.committed(state),
            )
            if len(self._known) >= MOST:
                self._known.clear()
            self._known[state] = known
        return known

    def received(self, state: State, channel: int, writes: Mapping[int, int]) -> Prospect | None:
        """What a broadcast of the environment, which writes by offset, leads to; None: nobody takes it.

        Raises:
            RangeError: an assignment is out of range.
        """
        key = (state, channel, tuple(writes.items()))
        if key in self._heard:
            return self._heard[key]
        transition = next(self._semantics.received(state, channel), None)
        found = None
        if transition is not None and transition.edges:
            fired = self._semantics.fire(state, transition.edges, writes)
            found = Prospect(self._semantics.network, state, transition, fired)
        if len(self._heard) >= MOST:
            self._heard.clear()
        self._heard[key] = found
        return found

    def _prospect(self, state: State, transition: Transition) -> Prospect | None:
        """None: it would break an invariant of a clock that it sets."""
        network = self._semantics.network
        try:
            fired = self._semantics.fire(state, transition.edges)
            invariant = self._semantics.invariant(fired.state)
        except RangeError as error:  # told when the edge is due, if ever
            return Prospect(network, state, transition, error)
        values = dict(fired.resets)
        if not all(_holds(values[bound.clock], bound) for bound in invariant if bound.clock in values):
            return None
        kept = tuple(bound for bound in invariant if bound.clock not in values)
        return Prospect(network, state, transition, fired, kept)


def _holds(value: int, bound: Bound) -> bool:
    return value < bound.value or (value == bound.value and bound.op == "<=")


def _told(network: Network, edge: Edge) -> TakenEdge:
    process = network.processes[edge.process]
    source, target = process.locations[edge.source], process.locations[edge.target]
    return TakenEdge(process.name, source.name, target.name, edge.index, edge.span.where)
