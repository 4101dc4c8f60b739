"""What of a model can happen: locations that are entered, edges that are taken."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from timed_automata import DrawnEdge, Edge, Network, Process
from timed_automata.explore._switched_off import switched_off


class Missing(NamedTuple):
    """What cannot happen, by template: no process of the template does it.

    Attributes:
        locations: never entered, ``Template.location``.
        edges: never taken, ``file:line:column: Template a → b (guard, synchronisation)``.
        off: edges that the constants switch off; they and the locations behind them are not in the others.
    """

    locations: tuple[str, ...]
    edges: tuple[str, ...]
    off: tuple[str, ...]


def missing(network: Network, visited: Iterable[tuple[int, ...]], taken: set[int]) -> Missing:
    """Compare with what the model has.

    Args:
        network: the model.
        visited: locations of all processes, as they were met together.
        taken: edges, by the ``id`` of what was drawn.
    """
    off = switched_off(network)
    reached = {
        (process.template, at)
        for locations in set(visited)
        for process, at in zip(network.processes, locations, strict=True)
    }
    locations = [
        f"{process.template}.{location.name}"
        for process in _one_of_each(network)
        for location in process.locations
        if (process.template, location.index) not in reached | off.locations
    ]
    idle = [(process, edge) for process, edge in _drawn(network) if id(edge.drawn) not in taken]
    return Missing(
        tuple(locations),
        tuple(_told(process, edge) for process, edge in idle if id(edge.drawn) not in off.edges),
        tuple(_told(process, edge) for process, edge in idle if id(edge.drawn) in off.edges),
    )


def _told(process: Process, edge: Edge) -> str:
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
