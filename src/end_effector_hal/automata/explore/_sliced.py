"""A network without the variables that nobody reads: fewer states, the same answers.

A variable that no guard, invariant, channel index, update or query reads cannot change what can happen. It keeps its
first value here, so that states that differ in it alone are one (cone of influence, variable by variable).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

from end_effector_hal.automata._network import Edge, Network, State
from end_effector_hal.automata._scope import Function
from end_effector_hal.automata._semantics import Fired
from end_effector_hal.automata.explore._listening import ListeningSemantics

_WORD = re.compile(r"[A-Za-z_]\w*")


class SlicedSemantics(ListeningSemantics):
    """The semantics of a network with respect to the texts of some queries."""

    def __init__(self, network: Network, queries: Iterable[str]) -> None:
        super().__init__(network)
        self.unread = unread(network, queries)
        first = network.initial.values
        self._constant = [
            (offset, first[offset])
            for variable in network.variables
            if variable.name in self.unread
            for offset in range(variable.offset, variable.offset + variable.type.size)
        ]

    def fire(self, state: State, edges: Sequence[Edge], writes: Mapping[int, int] | None = None) -> Fired:
        """Take a transition; what nobody reads stays as it is."""
        locations, values = list(state.locations), list(state.values)
        resets: list[tuple[int, int]] = []
        for offset, value in (writes or {}).items():
            values[offset] = value
        for edge in edges:
            locations[edge.process] = edge.target
            if edge.update is not None:
                edge.update(values, resets)
        for offset, value in self._constant:
            values[offset] = value
        return Fired(State(tuple(locations), tuple(values)), tuple(resets))


def unread(network: Network, queries: Iterable[str]) -> frozenset[str]:
    """The names of the variables that neither the network nor one of the queries reads."""
    read: set[str] = set()
    for process in network.processes:
        effects = [location.effects for location in process.locations]
        effects += [edge.effects for edge in process.edges]
        read = read.union(*(each.reads for each in effects))
    words = {word for query in queries for word in _WORD.findall(query)}
    for scope in (network.scope, *(process.scope for process in network.processes)):
        for name in words & scope.symbols.keys():
            symbol = scope.symbols[name]
            if isinstance(symbol, Function):
                read |= symbol.effects.reads
    names = {variable.name for variable in network.variables}
    return frozenset(name for name in names - read if name.rpartition(".")[2] not in words)
