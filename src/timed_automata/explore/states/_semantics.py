"""The semantics for an exploration: with a cache, and without the variables that nothing reads."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from operator import itemgetter
from typing import Any, NamedTuple

from timed_automata.compiler import Bound, Function, Values
from timed_automata.language import names_in
from timed_automata.network import Edge, Network, Semantics, State, Transition, effects_of

_MOST_KNOWN = 20_000  # of one location; what a process sees may hardly ever be the same


class _Started(NamedTuple):
    """An edge whose data guard holds; ``alone`` is the transition if no other process takes part."""

    edge: Edge
    bounds: tuple[Bound, ...]
    channel: int | None
    alone: Transition | None


_Active = tuple[Edge, Callable[[Values], Any] | None, Any]


class _StartCache:
    """The edges that leave a location and can start a transition.

    Edges that need a certain value of a variable are looked up by it: of a thousand edges that are selected by place
    (``j == focus``) only those of the current place are tested.
    """

    def __init__(self, network: Network, active: Sequence[_Active]) -> None:
        asked = {name for edge, _, _ in active for name in edge.asks}
        offsets = [offset for _, offset in _places(network, asked)]
        self._seen: Callable[[Values], object] = itemgetter(*offsets) if offsets else lambda _: None
        self._known: dict[object, tuple[_Started, ...]] = {}
        self._shared: dict[object, _Started] = {}
        self._always: list[tuple[int, _Active]] = []
        self._where: dict[int, dict[int, list[tuple[int, _Active]]]] = {}
        for number, one in enumerate(active):
            place = self._always
            for offset, value in one[0].guard.needed[:1]:
                place = self._where.setdefault(offset, {}).setdefault(value, [])
            place.append((number, one))

    def __bool__(self) -> bool:
        return bool(self._always or self._where)

    def started(self, values: Values) -> tuple[_Started, ...]:
        """Return the edges whose data guards hold."""
        seen = self._seen(values)
        found = self._known.get(seen)
        if found is None:
            if len(self._known) >= _MOST_KNOWN:
                self._known.clear()
            found = self._known[seen] = tuple(self._started(values))
        return found

    def _started(self, values: Values) -> Iterator[_Started]:
        possible = self._always
        if self._where:
            possible = [*possible]
            for offset, by_value in self._where.items():
                possible += by_value.get(values[offset], ())
            possible.sort(key=itemgetter(0))
        for _, (edge, data, clocks) in possible:
            if data is None or data(values):
                bounds, channel = clocks.at(values), edge.channel
                if channel is not None and not isinstance(channel, int):
                    channel = channel(values)
                key = (edge, bounds, channel)
                found = self._shared.get(key)
                if found is None:
                    alone = Transition((edge,), bounds, None) if channel is None else None
                    found = self._shared[key] = _Started(edge, bounds, channel, alone)
                yield found


_Starting = tuple[tuple[int, _StartCache], ...]  # by process


class CachedSemantics(Semantics):
    """Returns the same transitions in the same order as `Semantics` (a test compares both), from a cache.

    The edges that a process can start are computed once for equal values of the variables that they read.

    Attributes:
        fixed: variable, offset and value of the variables that keep their value.
    """

    def __init__(self, network: Network) -> None:
        super().__init__(network)
        self.fixed: Sequence[tuple[str, int, int]] = ()
        self._cache = [
            [(process, _StartCache(network, outgoing.active)) for outgoing in each]
            for process, each in enumerate(self._outgoing)
        ]
        self._starting: dict[tuple[int, ...], _Starting | None] = {}

    def transitions(self, state: State) -> Iterator[Transition]:
        """Yield all transitions whose data guards hold and that committed locations allow."""
        locations = state.locations
        try:
            starting = self._starting[locations]
        except KeyError:
            starting = self._starting[locations] = None if self.committed(state) else self._starts(locations)
        return super().transitions(state) if starting is None else self._uncommitted(state, starting)

    def _starts(self, locations: tuple[int, ...]) -> _Starting:
        """Return the processes that can start a transition."""
        caches = [cache[at] for cache, at in zip(self._cache, locations, strict=True)]
        return tuple([each for each in caches if each[1]])

    def _uncommitted(self, state: State, starting: _Starting) -> Iterator[Transition]:
        values = state.values
        for process, cache in starting:
            for edge, own, channel, alone in cache.started(values):
                if alone is not None:
                    yield alone
                elif channel is not None:
                    for receivers, bounds in self._receivers(state, channel, process):
                        yield Transition((edge, *receivers), own + bounds, channel)


class SlicedSemantics(CachedSemantics):
    """The semantics of a network reduced to what some queries need: fewer states, the same answers.

    A variable that no guard, invariant, channel index, update or query reads cannot change the behaviour. It keeps its
    initial value here, so that states that differ only in it are one (cone of influence, variable by variable).
    """

    def __init__(self, network: Network, queries: Iterable[str]) -> None:
        super().__init__(network)
        first = network.initial.values
        self.fixed = [
            (name, offset, first[offset]) for name, offset in _places(network, _unread(network, queries))
        ]


def _unread(network: Network, queries: Iterable[str]) -> set[str]:
    """Return the names of the variables that neither the network nor one of the queries reads."""
    read = set(effects_of(network.processes).reads)
    words = {word for query in queries for word in names_in(query)}
    for scope in (network.scope, *(process.scope for process in network.processes)):
        for name in words & scope.symbols.keys():
            symbol = scope.symbols[name]
            if isinstance(symbol, Function):
                read |= symbol.effects.reads
    names = {variable.name for variable in network.variables}
    return {name for name in names - read if name.rpartition(".")[2] not in words}


def _places(network: Network, names: Container[str]) -> Iterator[tuple[str, int]]:
    """Yield name and offset of every scalar of the named variables."""
    for variable in network.variables:
        if variable.name in names:
            for offset in range(variable.offset, variable.offset + variable.type.size):
                yield variable.name, offset
