"""The queries of a file that can be judged on a run: ``A[] p`` where p refers only to the executed side."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, field

from timed_automata.compiler import ClockSymbol, Function, Scope, Storage
from timed_automata.language import names_in
from timed_automata.network import Network, Process, State, effects_of
from timed_automata.queries import Case, Formula, compile_formula, parse_query


@dataclass(frozen=True, slots=True)
class MonitoredQuery:
    """A query that can be judged on a run.

    Attributes:
        text: the query as in the file.
        comment: its comment in the file.
    """

    text: str
    comment: str
    _violation: Formula = field(repr=False)

    def violations(self, state: State) -> list[Case]:
        """Return conjunctions of clock constraints; the query is violated if one of them holds."""
        return self._violation.cases(state)


def monitored_queries(network: Network, executed: Collection[int]) -> tuple[MonitoredQuery, ...]:
    """Return the queries of the file that refer only to the processes with these indices.

    Raises:
        ModelError: a query is outside of the supported subset.
    """
    key = monitored_queries, frozenset(executed)
    known: tuple[MonitoredQuery, ...] | None = network.derived.get(key)
    if known is None:
        known = network.derived[key] = _compiled(network, executed)
    return known


def _compiled(network: Network, executed: Collection[int]) -> tuple[MonitoredQuery, ...]:
    found = []
    for stored in network.document.queries:
        content = stored.formula.content
        if not content.strip() or not _speaks_of(network, executed, content):
            continue
        query = parse_query(stored.formula)
        if query.kind == "A[]" and query.condition is not None:
            violation = compile_formula(network, query.condition, negated=True)
            found.append(MonitoredQuery(str(query), stored.comment, violation))
    return tuple(found)


def _speaks_of(network: Network, executed: Collection[int], content: str) -> bool:
    """Return whether all names of a query are executed processes, or variables that these read or write."""
    words = names_in(content)
    ours = [process for process in network.processes if process.index in executed]
    theirs = {_plain(process) for process in network.processes} - {_plain(process) for process in ours}
    if "deadlock" in words or words & theirs:
        return False
    effects = effects_of(ours)
    names = set(_variables(network.scope, words))
    for process in ours:  # of its functions what they read of the network's
        names |= {name for name in _variables(process.scope, words) if "." not in name}
    return names <= effects.reads | effects.writes and bool(
        names or words & {_plain(process) for process in ours}
    )


def _plain(process: Process) -> str:
    return process.name.partition("(")[0]


def _variables(scope: Scope, words: set[str]) -> Iterator[str]:
    for word in words & scope.symbols.keys():
        symbol = scope.symbols[word]
        if isinstance(symbol, Storage | ClockSymbol):
            yield symbol.name
        elif isinstance(symbol, Function):
            yield from symbol.effects.reads
