"""Finds the locations and edges of a model that are never used, and those that its constants switch off."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from typing import NamedTuple

from timed_automata.compiler import Constant
from timed_automata.document import DrawnEdge
from timed_automata.explore.properties._zeno import Taken
from timed_automata.explore.states import StateRecord
from timed_automata.explore.states._discrete import Action
from timed_automata.language import names_in
from timed_automata.network import Edge, Network, Process


class CoverageReport(NamedTuple):
    """Locations and edges that no process of a template ever uses.

    Attributes:
        locations: never entered, ``Template.location``.
        edges: never taken, ``file:line:column: Template a → b (guard, synchronisation)``.
        disabled: edges that the constants switch off; they and the locations behind them are not in the other lists.
    """

    locations: tuple[str, ...]
    edges: tuple[str, ...]
    disabled: tuple[str, ...]


class Coverage:
    """Collects the locations and edges that a search has reached, part by part."""

    def __init__(self) -> None:
        self._visited: set[tuple[int, ...]] = set()
        self._actions: set[Action] = set()

    def add(self, records: Iterable[StateRecord], arcs: Iterable[Taken]) -> None:
        """Record the states that were reached, and the transitions that were taken from them."""
        self._visited |= {record.discrete.vector.locations for record in records if record.passed}
        self._actions |= {move.action for _, _, move in arcs}

    def report(self, network: Network) -> CoverageReport:
        """Compare the recorded states and transitions with the model."""
        fired = {id(edge.drawn) for action in self._actions for edge in action.edges}
        off = _statically_disabled(network)
        reached = {
            (process.template, at)
            for locations in self._visited
            for process, at in zip(network.processes, locations, strict=True)
        }
        locations = [
            f"{process.template}.{location.name}"
            for process in _one_of_each(network)
            for location in process.locations
            if (process.template, location.index) not in reached | off.locations
        ]
        idle = [(process, edge) for process, edge in _drawn(network) if id(edge.drawn) not in fired]
        return CoverageReport(
            tuple(locations),
            tuple(_described(process, edge) for process, edge in idle if id(edge.drawn) not in off.edges),
            tuple(_described(process, edge) for process, edge in idle if id(edge.drawn) in off.edges),
        )


def _described(process: Process, edge: Edge) -> str:
    names = " → ".join(process.locations[at].name for at in (edge.source, edge.target))
    return f"{edge.span.where}: {process.template} {names}{_labels(edge.drawn)}"


def _labels(edge: DrawnEdge) -> str:
    found = [edge.labels[kind].text.content for kind in ("guard", "synchronisation") if kind in edge.labels]
    return f" ({', '.join(' '.join(label.split()) for label in found)})" if found else ""


def _drawn(network: Network) -> Iterator[tuple[Process, Edge]]:
    """Yield every edge of the file once, with a process of its template."""
    for process in _one_of_each(network):
        yield from {id(edge.drawn): (process, edge) for edge in process.edges}.values()


def _one_of_each(network: Network) -> Iterable[Process]:
    """Return one process for every template."""
    return {process.template: process for process in reversed(network.processes)}.values()


def open_channels(network: Network) -> Iterator[str]:
    """Yield the channels without a sender or without a receiver, in words."""
    ends: dict[int, set[str]] = {number: set() for number in range(len(network.channels))}
    for process in network.processes:
        for edge in process.edges:
            for channel in edge.channels:
                ends[channel].add(edge.direction)
    for number, found in ends.items():
        if found != {"!", "?"}:
            missing = {frozenset("!"): "no edge receives on it", frozenset("?"): "no edge sends on it"}
            yield f"{network.channels[number].name}: {missing.get(frozenset(found), 'no edge uses it')}"


def equal_names(network: Network) -> Iterator[str]:
    """Yield the global constants that name the same value of a type, in words.

    The constants of a typedef name the values of the variables that are declared with it: a value has one name.
    """
    named = {each.type.name for each in network.variables if each.type.name}
    known: dict[tuple[str, int], str] = {}
    for name, symbol in network.scope.symbols.items():
        if isinstance(symbol, Constant) and symbol.type.name in named and symbol.type.single:
            first = known.setdefault((symbol.type.name, symbol.values[0]), name)
            if first != name:
                yield f"{first} and {name} are both {symbol.values[0]} ({symbol.type.name})"


class _DisabledParts(NamedTuple):
    """Disabled edges by the ``id`` of the drawn edge, which all processes of a template share, and disabled locations
    by template and number.
    """

    edges: frozenset[int]
    locations: frozenset[tuple[str, int]]


def _statically_disabled(network: Network) -> _DisabledParts:
    """Return the edges whose guard the constants make false, and all parts that are only reachable through such edges.

    A false guard without a constant is not a switch: the parts behind it are expected to happen.
    """
    every = [edge for process in network.processes for edge in process.edges]
    possible = {id(edge.drawn) for edge in every if not edge.guard.never}
    switches = {
        id(edge.drawn)
        for edge in every
        if id(edge.drawn) not in possible and _mentions(edge, network.constants.keys())
    }
    if not switches:
        return _DisabledParts(frozenset(), frozenset())
    without, with_ = _dead(network, frozenset()), _dead(network, frozenset(switches))
    return _DisabledParts(with_.edges - without.edges, with_.locations - without.locations)


def _mentions(edge: Edge, names: Collection[str]) -> bool:
    guard = edge.drawn.labels.get("guard")
    return guard is not None and not names_in(guard.text.content).isdisjoint(names)


def _dead(network: Network, off: frozenset[int]) -> _DisabledParts:
    """Return the parts that no process can use if the edges ``off`` are disabled, by the graphs and the channels'
    senders.
    """
    while True:
        reached = {process.index: set(_reached(process, off)) for process in network.processes}
        edges = [
            edge
            for process in network.processes
            for edge in process.edges
            if edge.source in reached[process.index] and id(edge.drawn) not in off
        ]
        sent = {channel for edge in edges if edge.direction == "!" for channel in edge.channels}
        alive = {
            id(edge.drawn) for edge in edges if edge.direction != "?" or sent.intersection(edge.channels)
        }
        dead = frozenset({id(e.drawn) for p in network.processes for e in p.edges} - alive)
        if dead == off:
            break
        off = dead
    places = {(process.template, at) for process in network.processes for at in reached[process.index]}
    every = {(process.template, at) for process in network.processes for at in range(len(process.locations))}
    return _DisabledParts(dead, frozenset(every - places))


def _reached(process: Process, off: frozenset[int]) -> Iterator[int]:
    """Yield the locations that a path of edges connects to the initial one; the edges in ``off`` do not count."""
    seen, waiting = {process.initial}, [process.initial]
    while waiting:
        at = waiting.pop()
        yield at
        for edge in process.edges:
            if edge.source == at and id(edge.drawn) not in off and edge.target not in seen:
                seen.add(edge.target)
                waiting.append(edge.target)
