"""What of a model can happen: locations that are entered, edges that are taken."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from timed_automata.document import DrawnEdge
from timed_automata.explore.properties._statically_disabled import statically_disabled
from timed_automata.explore.properties._zeno import Taken
from timed_automata.explore.states import SymbolicSpace
from timed_automata.network import Edge, Network, Process


class CoverageReport(NamedTuple):
    """What cannot happen, by template: no process of the template does it.

    Attributes:
        locations: never entered, ``Template.location``.
        edges: never taken, ``file:line:column: Template a → b (guard, synchronisation)``.
        disabled: edges that the constants switch off; they and the locations behind them are not in the others.
    """

    locations: tuple[str, ...]
    edges: tuple[str, ...]
    disabled: tuple[str, ...]


def coverage_report(space: SymbolicSpace, arcs: Iterable[Taken]) -> CoverageReport:
    """Compare what a whole search has met, and the transitions it has taken, with what the model has."""
    network, actions = space.discrete.network, {move.action for _, _, move in arcs}
    fired = {id(edge.drawn) for action in actions for edge in action.edges}
    visited = {record.discrete.vector.locations for record in space.records if record.passed}
    off = statically_disabled(network)
    reached = {
        (process.template, at)
        for locations in visited
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
    """Each edge that was drawn, once."""
    for process in _one_of_each(network):
        yield from {id(edge.drawn): (process, edge) for edge in process.edges}.values()


def _one_of_each(network: Network) -> Iterable[Process]:
    """A process of each template."""
    return {process.template: process for process in reversed(network.processes)}.values()


def open_channels(network: Network) -> Iterator[str]:
    """Channels with one end only, or with none."""
    ends: dict[int, set[str]] = {number: set() for number in range(len(network.channels))}
    for process in network.processes:
        for edge in process.edges:
            for channel in edge.channels:
                ends[channel].add(edge.direction)
    for number, found in ends.items():
        if found != {"!", "?"}:
            missing = {frozenset("!"): "nobody receives on it", frozenset("?"): "nobody sends on it"}
            yield f"{network.channels[number].name}: {missing.get(frozenset(found), 'nobody uses it')}"
