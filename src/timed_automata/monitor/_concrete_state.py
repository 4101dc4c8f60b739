"""The state of a network during a recorded run, and descriptions of its steps in words.

A state has locations and values of clocks; the transitions that may follow are computed from it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import NamedTuple

from timed_automata.compiler import COMPARISONS, Bound
from timed_automata.errors import RangeError
from timed_automata.execute import ExecutionSnapshot, Resumed, Step, snapshot_of
from timed_automata.network import Change, Edge, Fired, Network, Semantics, State, Transition

_LONG_AGO = -(1 << 62)


class TimedTransition(NamedTuple):
    """A transition that can be taken from ``due`` on.

    Attributes:
        transition: the transition.
        since: time since which its data guards hold.
        reached: time at which its clocks reach the last of its lower bounds; far in the past without one.
        due: the later of ``since`` and ``reached``.
    """

    transition: Transition
    since: int
    reached: int
    due: int


class ConcreteState:
    """Follows a run without judging it.

    Args:
        network: a loaded network.
        ours: indices of the processes that move by themselves.
        unit: length of the model's unit, in units of the run's time.

    Attributes:
        state: locations and values.
        entered: time at which this discrete state was entered.
        timed: transitions that can be taken in it, in the order of the file.
    """

    def __init__(self, network: Network, ours: Collection[int], unit: int) -> None:
        self.network, self._unit = network, unit
        self._semantics = Semantics(network, ours)
        self.begin(0)

    def begin(self, at: int) -> None:
        """Start in the initial state with all clocks zero at ``at``."""
        self._zero = [at] * len(self.network.clocks)
        self.timed: tuple[TimedTransition, ...] = ()
        self._renew(self.network.initial, at, None)

    def resume(self, resumed: Resumed, entered: int) -> None:
        """Continue from the state of an execution that entered its discrete state at ``entered``."""
        self._zero = list(resumed.zeros)
        self.state, self.entered = resumed.state, entered
        self.timed = tuple(self._found({}))

    def snapshot(self, at: int) -> ExecutionSnapshot:
        """Return the state at ``at`` as a snapshot."""
        return snapshot_of(self.network, self.state, self._zero, at=at, entered=self.entered)

    def write(self, writes: Mapping[str, int], at: int) -> None:
        """Set variables on behalf of the environment."""
        values = list(self.state.values)
        for name, value in writes.items():
            values[self.network.offset(name)] = value
        state = State(self.state.locations, tuple(values))
        if state != self.state:
            self._renew(state, at, None)

    def move(self, transition: Transition, fired: Fired, at: int) -> None:
        """Take a transition."""
        for clock, value in fired.resets:
            self._zero[clock] = at - value * self._unit
        self._renew(fired.state, at, transition)

    def fire(self, edges: tuple[Edge, ...], writes: Mapping[str, int] | None = None) -> Fired:
        """Return the result of a transition; raise RangeError if a value leaves its range."""
        offsets = {self.network.offset(name): value for name, value in (writes or {}).items()}
        return self._semantics.fire(self.state, edges, offsets)

    def transitions(self) -> Iterator[Transition]:
        """Yield the transitions whose data guards hold."""
        return self._semantics.transitions(self.state)

    def reception(self, channel: int) -> Transition | None:
        """Return the transition that receives a broadcast of the environment, or None if no edge does."""
        found = next(self._semantics.received(self.state, channel), None)
        return found if found is not None and found.edges else None

    def may_delay(self) -> bool:
        """Return whether time may pass."""
        return self._semantics.may_delay(self.state)

    def holds(self, bounds: Iterable[Bound], at: int) -> bool:
        """Return whether clock constraints hold at an instant."""
        unit = self._unit
        return all(
            COMPARISONS[b.op](at - self._zero[b.clock] if b.clock else 0, b.value * unit) for b in bounds
        )

    def enabled(self, transition: Transition, at: int) -> bool:
        """Return whether the lower bounds of its guards hold, and those of the target's invariant."""
        return self.holds(_lower([*transition.bounds, *self._kept(transition)]), at)

    def stays(self, at: int) -> bool:
        """Return whether the invariants hold at an instant."""
        return self._semantics.allowed(self.state) and self.holds(self._semantics.invariant(self.state), at)

    def in_time(self, transition: Transition, at: int) -> bool:
        """Return whether upper bounds and invariants, including the target's, allow a transition at an instant."""
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
        """Return the first whole instant at which a lower bound holds."""
        return self._zero[bound.clock] + bound.value * self._unit + (bound.op == ">")

    def _kept(self, transition: Transition) -> list[Bound]:
        """Return the bounds of the target's invariant on clocks that the transition does not set."""
        bounds, values = self._target(transition)
        return [bound for bound in bounds if bound.clock not in values]

    def _enters(self, transition: Transition) -> bool:
        """Return whether the target's invariant allows the values that the transition sets."""
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


_LONGEST = 10**30


def recorded_in(concrete: ConcreteState, step: Step) -> Transition | None:
    """Return the transition with exactly the edges that a step names; None if there is none.

    Where clocks decide who receives a broadcast, several have the same edges: then it is the one that is possible now.
    """
    found = [each for each in concrete.transitions() if same_edges(concrete.network, each, step)]
    return next((each for each in found if concrete.holds(each.bounds, step.at)), found[0] if found else None)


def same_edges(network: Network, transition: Transition, step: Step) -> bool:
    """Return whether a step names exactly the edges of this transition, by number and by locations."""
    ours = [_names(network, edge) for edge in transition.edges]
    return ours == [(edge.process, edge.source, edge.target, edge.index) for edge in step.edges]


def named(step: Step) -> str:
    """Return the edges of a step in words: ``Gripper Step → Reset with Actuator(1) Pending → Off``."""
    return " with ".join(f"{edge.process} {edge.source} → {edge.target}" for edge in step.edges)


def in_words(network: Network, edges: Iterable[Edge]) -> str:
    """Return edges of a network in the same words as `named`."""
    names = (_names(network, edge) for edge in edges)
    return " with ".join(f"{process} {source} → {target}" for process, source, target, _ in names)


def changes_in_words(changes: Iterable[Change]) -> str:
    """Return changes in words: ``ee 1 → 3, command 2 → -1``."""
    return ", ".join(f"{change.name} {change.old} → {change.new}" for change in changes) or "nothing"


def why_not(network: Network, state: State, step: Step) -> str:
    """Return the reason why a step cannot be taken in a state."""
    known = {process.name: process for process in network.processes}
    for taken in step.edges:
        process = known.get(taken.process)
        if process is None or not 0 <= taken.index < len(process.edges):
            return f"there is no edge {shortened(taken.index)} of {taken.process}"
        edge, here = process.edges[taken.index], state.locations[process.index]
        if here != edge.source:
            return f"{taken.process} is in {process.locations[here].name}"
        _, source, target, _ = _names(network, edge)
        if (taken.source, taken.target) != (source, target):
            return f"edge {taken.index} of {taken.process} leads from {source} to {target}"
    return "a guard or the synchronisation does not hold"


def shortened(number: int | None) -> str:
    """Return a recorded number as text; a very long one is not printed."""
    return str(number) if number is None or abs(number) < _LONGEST else "a number of many digits"


def _names(network: Network, edge: Edge) -> tuple[str, str, str, int]:
    process = network.processes[edge.process]
    source, target = process.locations[edge.source].name, process.locations[edge.target].name
    return process.name, source, target, edge.index
