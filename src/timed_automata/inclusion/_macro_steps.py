"""Macro-steps: a first transition, then transitions out of committed locations, all at one instant."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from timed_automata.compiler import Bound
from timed_automata.document import fault
from timed_automata.inclusion._interface import Side
from timed_automata.network import Edge, Location, Semantics, State, Transition

_LONGEST = 200  # transitions out of committed locations, one after the other
Seen = tuple[str, ...]


class MacroStep(NamedTuple):
    """One macro-step: all transitions of one instant.

    Attributes:
        edges: the edges that are taken, in order.
        channel: number of the channel of the first transition.
        bounds: constraints on the clocks before the step from all its guards and invariants, by their place in zones.
        resets: new values of clocks, by their place in zones.
        first: the state after the first transition.
        state: the final state.
        seen: outputs and changes of observed variables, in order.
    """

    edges: tuple[Edge, ...]
    channel: int | None
    bounds: tuple[Bound, ...]
    resets: Mapping[int, int]
    first: State
    state: State
    seen: Seen


class _Way(NamedTuple):
    """The first transitions of a macro-step that is not complete yet."""

    edges: tuple[Edge, ...]
    bounds: tuple[Bound, ...]
    resets: Mapping[int, int]
    first: State | None
    state: State
    seen: Seen
    length: int


class MacroSteps:
    """Computes the macro-steps of one side, once per state."""

    def __init__(self, side: Side) -> None:
        self.side, self.semantics = side, Semantics(side.network, side.processes)
        self._known: dict[State, list[MacroStep]] = {}

    def of(self, state: State) -> list[MacroStep]:
        """Return the macro-steps that a participating process begins."""
        found = self._known.get(state)
        if found is None:
            found = self._known[state] = list(self._following(state, self.semantics.transitions(state)))
        return found

    def to(self, state: State, channel: int | None, writes: Mapping[int, int]) -> list[MacroStep]:
        """Return the macro-steps that an input begins: values of variables, and an event on a channel."""
        begun: Iterable[Transition] = [Transition((), (), None)]
        if channel is not None:
            begun = self.semantics.received(state, channel)
        return list(self._following(state, begun, writes))

    def invariant(self, state: State, *, environment: bool | None = None) -> tuple[Bound, ...]:
        """Return the bounds of clocks in a state, by place in zones; ``environment`` selects its processes or the
        others.
        """
        return tuple(
            self._placed(bound)
            for process in self.side.processes
            if environment is None or (process in self.side.environment) is environment
            for constraint in self._location(process, state).invariant.clocks
            for bound in [constraint.at(state.values)]
        )

    def _location(self, process: int, state: State) -> Location:
        return self.side.network.processes[process].locations[state.locations[process]]

    def _placed(self, bound: Bound) -> Bound:
        return Bound(self.side.index[bound.clock], bound.op, bound.value)

    def _following(
        self, state: State, begun: Iterable[Transition], writes: Mapping[int, int] | None = None
    ) -> Iterator[MacroStep]:
        start = _Way((), (), {}, None, state, (), 0)
        for transition in begun:
            way = self._after(start, transition, writes)
            if way is not None:
                yield from self._ends(way, transition.channel)

    def _ends(self, way: _Way, channel: int | None) -> Iterator[MacroStep]:
        waiting = [way]
        while waiting:
            way = waiting.pop()
            assert way.first is not None
            if not self.semantics.committed(way.state):
                yield MacroStep(way.edges, channel, way.bounds, way.resets, way.first, way.state, way.seen)
                continue
            if way.length >= _LONGEST:
                what = f"A chain of committed locations is longer than {_LONGEST} transitions."
                raise fault(way.edges[-1].span, what, "Does it end?")
            after = (self._after(way, each) for each in self.semantics.transitions(way.state))
            waiting += reversed([each for each in after if each is not None])

    def _after(
        self, way: _Way, transition: Transition, writes: Mapping[int, int] | None = None
    ) -> _Way | None:
        """Return the macro-step with one more transition, or None if that is not possible."""
        bounds = self._still(way, [self._placed(bound) for bound in transition.bounds])
        if bounds is None:
            return None
        state, resets = self.semantics.fire(way.state, transition.edges, writes)
        if not self.semantics.allowed(state):
            return None
        index = self.side.index
        set_ = {**way.resets, **{index[clock]: value for clock, value in resets if clock in index}}
        seen = (*way.seen, *self._seen(transition, way.state, state))
        way = _Way(
            (*way.edges, *transition.edges),
            bounds,
            set_,
            way.first or state,
            state,
            seen,
            way.length + 1,
        )
        bounds = self._still(way, self.invariant(state))
        return None if bounds is None else way._replace(bounds=bounds)

    @staticmethod
    def _still(way: _Way, more: Sequence[Bound]) -> tuple[Bound, ...] | None:
        """Return the bounds at the beginning that also ensure ``more`` now, or None if that is impossible."""
        needed = list(way.bounds)
        for bound in more:
            if bound.clock not in way.resets:
                needed.append(bound)
            elif not bound.allows(way.resets[bound.clock]):
                return None
        return tuple(needed)

    def _seen(self, transition: Transition, before: State, after: State) -> Iterator[str]:
        sent = self.side.outputs.get(transition.channel) if transition.channel is not None else None
        if sent is not None:
            yield f"{sent}!"
        changes = [
            f"{name} {before.values[at]} → {after.values[at]}"
            for name, at in self.side.observed
            if before.values[at] != after.values[at]
        ]
        if changes:
            yield ", ".join(changes)
