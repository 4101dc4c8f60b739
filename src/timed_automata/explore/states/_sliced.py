"""A network without the variables that nothing reads: fewer states, the same answers.

A variable that no guard, invariant, channel index, update or query reads cannot change what can happen. It keeps its
first value here, so that states that differ in it alone are one (cone of influence, variable by variable).
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from timed_automata.compiler import Function
from timed_automata.explore.states._cached_semantics import CachedSemantics
from timed_automata.network import Network

_WORD = re.compile(r"[A-Za-z_]\w*")


class SlicedSemantics(CachedSemantics):
    """The semantics of a network with respect to the texts of some queries."""

    def __init__(self, network: Network, queries: Iterable[str]) -> None:
        super().__init__(network)
        self.unread = unread(network, queries)
        first = network.initial.values
        self.fixed = [
            (variable.name, offset, first[offset])
            for variable in network.variables
            if variable.name in self.unread
            for offset in range(variable.offset, variable.offset + variable.type.size)
        ]


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
