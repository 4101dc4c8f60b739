"""The semantics, faster: who listens to a channel is known, and what a process could begin where it saw the same."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import product
from operator import itemgetter
from typing import Any, NamedTuple

from timed_automata import Bound, Edge, Network, Semantics, State, Transition, Values
from timed_automata.explore._firing import Fixed

_MOST_KNOWN = 20_000  # of one location; what a process sees may hardly ever be the same
_NOBODY: tuple[tuple[tuple[()], tuple[()]], ...] = (((), ()),)

Answers = Sequence[tuple[tuple[Edge, ...], tuple[Bound, ...]]]


class _Begun(NamedTuple):
    """An edge whose data guard holds; ``alone``: the transition, if nobody else takes part."""

    edge: Edge
    bounds: tuple[Bound, ...]
    channel: int | None
    alone: Transition | None


class _Here:
    """The edges that leave a location and can start a transition."""

    def __init__(
        self, network: Network, active: Sequence[tuple[Edge, Callable[[Values], Any] | None, Any]]
    ) -> None:
        self._active = active
        asked = {name for edge, _, _ in active for name in edge.asks}
        offsets = [
            offset
            for variable in network.variables
            if variable.name in asked
            for offset in range(variable.offset, variable.offset + variable.type.size)
        ]
        self._seen: Callable[[Values], object] = itemgetter(*offsets) if offsets else lambda _: None
        self._known: dict[object, tuple[_Begun, ...]] = {}
        self._shared: dict[object, _Begun] = {}

    def begun(self, values: Values) -> tuple[_Begun, ...]:
        """Those whose data guards hold."""
        seen = self._seen(values)
        found = self._known.get(seen)
        if found is None:
            found = tuple(self._begun(values))
            if len(self._known) < _MOST_KNOWN:
                self._known[seen] = found
        return found

    def _begun(self, values: Values) -> Iterator[_Begun]:
        for edge, data, clocks in self._active:
            if data is None or data(values):
                bounds, channel = clocks.at(values), edge.channel
                if channel is not None and not isinstance(channel, int):
                    channel = channel(values)
                key = (edge, bounds, channel)
                found = self._shared.get(key)
                if found is None:
                    alone = Transition((edge,), bounds, None) if channel is None else None
                    found = self._shared[key] = _Begun(edge, bounds, channel, alone)
                yield found


class ListeningSemantics(Semantics):
    """Gives the same transitions in the same order (a test holds it against its base)."""

    def __init__(self, network: Network) -> None:
        super().__init__(network)
        self._broadcast = [channel.broadcast for channel in network.channels]
        self._hearing = [
            [(process, self._leaving[process]) for process in listeners] for listeners in self._listeners
        ]
        self.fixed: Fixed = ()
        self._here = [[_Here(network, leaving.active) for leaving in process] for process in self._leaving]

    def transitions(self, state: State) -> Iterator[Transition]:
        """All transitions whose data guards hold and that committed locations allow."""
        locations, values = state
        if self._candidates(locations).committed:
            yield from self._committed(state)
            return
        for process, here in enumerate(self._here):
            for edge, own, channel, alone in here[locations[process]].begun(values):
                if alone is not None:
                    yield alone
                elif channel is not None:
                    for receivers, bounds in self._answers(state, channel, process):
                        yield Transition((edge, *receivers), own + bounds, channel)

    def _committed(self, state: State) -> Iterator[Transition]:
        """Where a process is in a committed location, few edges can start anything."""
        locations, values = state
        committed, candidates = self._candidates(locations)
        for process, free, edge, data, clocks in candidates:
            if data is not None and not data(values):
                continue
            channel = edge.channel
            if channel is None:
                yield Transition((edge,), clocks.at(values), None)
                continue
            if not isinstance(channel, int):
                channel = channel(values)
            for receivers, bounds in self._answers(state, channel, process):
                if free or any(other.process in committed for other in receivers):
                    yield Transition((edge, *receivers), clocks.at(values) + bounds, channel)

    def _answers(self, state: State, channel: int, sender: int) -> Answers:
        """Who takes part besides the sender: every choice."""
        locations, values = state
        choices = [
            enabled
            for process, leaving in self._hearing[channel]
            if process != sender and (enabled := leaving[locations[process]].receivers(channel, values))
        ]
        if not self._broadcast[channel]:
            return [((edge,), bounds) for enabled in choices for edge, bounds in enabled]
        if not choices:
            return _NOBODY
        if len(choices) == 1:
            return [((edge,), bounds) for edge, bounds in choices[0]]
        return [
            (tuple([edge for edge, _ in choice]), tuple([b for _, bounds in choice for b in bounds]))
            for choice in product(*choices)
        ]
