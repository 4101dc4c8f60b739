"""A network in one concrete state: where its processes are, the values of its clocks, what may come next."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import NamedTuple

from timed_automata.compiler import COMPARISONS, Bound
from timed_automata.errors import RangeError
from timed_automata.execute import ExecutionSnapshot, Resumed, snapshot_of
from timed_automata.network import Edge, Fired, Network, Semantics, State, Transition

_LONG_AGO = -(1 << 62)


class TimedTransition(NamedTuple):
    """A transition that can be taken from ``due`` on.

    Attributes:
        transition: which.
        since: when its data guards began to hold.
        reached: when its clocks reach the last of its lower bounds; far in the past without one.
        due: the later of the two.
    """

    transition: Transition
    since: int
    reached: int
    due: int


class ConcreteState:
    """Follows a run; says nothing against it.

    Args:
        network: a loaded network.
        ours: indices of the processes that move by themselves.
        unit: length of the model's unit, in units of the run's time.

    Attributes:
        state: locations and values.
        entered: when this discrete state was entered.
        timed: what can be taken in it, in the order of the file.
    """

    def __init__(self, network: Network, ours: Collection[int], unit: int) -> None:
        self.network, self._unit = network, unit
        self._semantics = Semantics(network, ours)
        self.begin(0)

    def begin(self, at: int) -> None:
        """All clocks are zero at ``at``."""
        self._zero = [at] * len(self.network.clocks)
        self.timed: tuple[TimedTransition, ...] = ()
        self._renew(self.network.initial, at, None)

    def resume(self, resumed: Resumed, entered: int) -> None:
        """Stand where an execution stood that has entered its discrete state at ``entered``."""
        self._zero = list(resumed.zeros)
        self.state, self.entered = resumed.state, entered
        self.timed = tuple(self._found({}))

    def snapshot(self, at: int) -> ExecutionSnapshot:
        """Where it stands at ``at``."""
        return snapshot_of(self.network, self.state, self._zero, at=at, entered=self.entered)

    def write(self, writes: Mapping[str, int], at: int) -> None:
        """The environment sets variables."""
        values = list(self.state.values)
        for name, value in writes.items():
            values[self.network.offset(name)] = value
        state = State(self.state.locations, tuple(values))
        if state != self.state:
            self._renew(state, at, None)

    def move(self, transition: Transition, fired: Fired, at: int) -> None:
        """A transition is taken."""
        for clock, value in fired.resets:
            self._zero[clock] = at - value * self._unit
        self._renew(fired.state, at, transition)

    def fire(self, edges: tuple[Edge, ...], writes: Mapping[str, int] | None = None) -> Fired:
        """What a transition leads to; raises RangeError."""
        offsets = {self.network.offset(name): value for name, value in (writes or {}).items()}
        return self._semantics.fire(self.state, edges, offsets)

    def transitions(self) -> Iterator[Transition]:
        """Those whose data guards hold."""
        return self._semantics.transitions(self.state)

    def reception(self, channel: int) -> Transition | None:
        """What a broadcast of the environment does; None: no edge receives it."""
        found = next(self._semantics.received(self.state, channel), None)
        return found if found is not None and found.edges else None

    def may_delay(self) -> bool:
        """Whether time may pass."""
        return self._semantics.may_delay(self.state)

    def holds(self, bounds: Iterable[Bound], at: int) -> bool:
        """Whether clock constraints hold at an instant."""
        unit = self._unit
        return all(
            COMPARISONS[b.op](at - self._zero[b.clock] if b.clock else 0, b.value * unit) for b in bounds
        )

    def enabled(self, transition: Transition, at: int) -> bool:
        """Whether the lower bounds of its guards hold, and those of the target."""
        return self.holds(_lower([*transition.bounds, *self._kept(transition)]), at)

    def stays(self, at: int) -> bool:
        """Whether the invariants hold at an instant."""
        return self._semantics.allowed(self.state) and self.holds(self._semantics.invariant(self.state), at)

    def in_time(self, transition: Transition, at: int) -> bool:
        """Whether upper bounds and invariants, those of the target included, allow a transition at an instant."""
        return self.stays(at) and self.holds(_upper([*transition.bounds, *self._kept(transition)]), at)

    def _renew(self, state: State, at: int, taken: Transition | None) -> None:
        ages = {each.transition.edges: each.since for each in self.timed}
        if taken is not None:
            ages.pop(taken.edges, None)
        self.state, self.entered = state, at
        self.timed = tuple(self._found(ages))

    def _found(self, ages: Mapping[tuple[Edge, ...], int]) -> Iterator[TimedTransition]:
        hurry = not self.may_delay()
        # what earlier lateness has broken already says nothing against another edge
        expired = () if self.stays(self.entered) else self._semantics.invariant(self.state)
        for transition in self.transitions():
            since = ages.get(transition.edges, self.entered)
            kept = self._kept(transition)
            reached = max(map(self._instant, _lower([*transition.bounds, *kept])), default=_LONG_AGO)
            due = max(since, reached)
            uppers = _upper([*transition.bounds, *(bound for bound in kept if bound not in expired)])
            if self.holds(uppers, due) and self._enters(transition) and not (hurry and due > self.entered):
                yield TimedTransition(transition, since, reached, due)

    def _instant(self, bound: Bound) -> int:
        """The first whole instant at which a lower bound holds."""
        return self._zero[bound.clock] + bound.value * self._unit + (bound.op == ">")

    def _kept(self, transition: Transition) -> list[Bound]:
        """What the target asks of the clocks that are not set on the way."""
        bounds, values = self._target(transition)
        return [bound for bound in bounds if bound.clock not in values]

    def _enters(self, transition: Transition) -> bool:
        """Whether the target allows the values that clocks are set to."""
        bounds, values = self._target(transition)
        return all(bound.allows(values[bound.clock]) for bound in bounds if bound.clock in values)

    def _target(self, transition: Transition) -> tuple[list[Bound], dict[int, int]]:
        try:
            fired = self.fire(transition.edges)
        except RangeError:  # raised when it is taken, if ever
            return [], {}
        return self._semantics.invariant(fired.state), dict(fired.resets)


def _lower(bounds: Iterable[Bound]) -> list[Bound]:
    return [bound for bound in bounds if bound.op not in ("<", "<=")]


def _upper(bounds: Iterable[Bound]) -> list[Bound]:
    return [bound for bound in bounds if bound.op in ("<", "<=", "==")]
