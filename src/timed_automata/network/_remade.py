"""Makes the network of an edited document from the network of the original: only edited parts are compiled."""

from __future__ import annotations

from dataclasses import replace

from timed_automata.compiler import Expressions
from timed_automata.document import Document, Template
from timed_automata.network._network import Edge, Network, Process
from timed_automata.network._templates import make_edges, make_location, parse_edge


def remake_network(network: Network, document: Document) -> Network | None:
    """Make the network of a document that differs from the network's only in edges, invariants and kinds of locations.

    The result shares the generated code of the network.

    Returns:
        The network, or None if more differs: then it must be made completely.

    Raises:
        ModelError: an edited part is not valid.
    """
    known, templates = network.document.templates, document.templates
    if replace(document, templates=known) != network.document or not all(map(_alike, known, templates)):
        return None
    edited = {
        new.name.content.strip(): new for old, new in zip(known, templates, strict=True) if new is not old
    }
    processes = [
        _remade(network, each, edited[each.template]) if each.template in edited else each
        for each in network.processes
    ]
    return replace(network, document=document, processes=tuple(processes))


def _alike(old: Template, new: Template) -> bool:
    """Return whether two templates differ only in edges, invariants and kinds of locations."""
    return replace(new, edges=old.edges, locations=old.locations) == old and [
        (each.id, each.name) for each in new.locations
    ] == [(each.id, each.name) for each in old.locations]


def _remade(network: Network, process: Process, template: Template) -> Process:
    numbers = {each.id: number for number, each in enumerate(template.locations)}
    known: dict[int, list[Edge]] = {}
    for edge in process.edges:
        known.setdefault(id(edge.drawn), []).append(edge)
    edges: list[Edge] = []
    for drawn in template.edges:
        if id(drawn) in known:
            edges += (replace(each, index=n) for n, each in enumerate(known[id(drawn)], start=len(edges)))
        else:
            parsed = parse_edge(drawn, numbers)
            edges += make_edges(network.code, process.scope, parsed, process.index, len(edges))
    locations = tuple(
        made
        if made.drawn is drawn
        else make_location(Expressions(network.code, process.scope), drawn, made.name, made.index)
        for made, drawn in zip(process.locations, template.locations, strict=True)
    )
    return replace(process, edges=tuple(edges), locations=locations)
