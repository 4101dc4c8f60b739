"""Finds all faults of a file: the label with a fault is removed, and the rest is read again.

Removing a label cannot make another label wrong, so every reported fault is real. A fault in declarations, parameters
or the system section ends the search, because everything else depends on them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from timed_automata.document import Document, DrawnEdge, DrawnLocation, Label, StoredQuery, Template
from timed_automata.errors import Diagnostic, ModelError
from timed_automata.network import Given, Network, make_network
from timed_automata.queries import Query, compile_clock, compile_formula, compile_integer, parse_query

_MOST = 50  # faults: more say nothing new
_Place = tuple[int, int]


def find_faults(document: Document, constants: Mapping[str, Given] | None = None) -> list[ModelError]:
    """Return every fault of a document's texts and queries in file order; an empty list means that it is valid.

    Raises:
        UsageError: a given constant does not exist, or does not fit its declaration.
    """
    faults: list[ModelError] = []
    network: Network | None = None
    rest: Document | None = document
    while rest is not None and len(faults) < _MOST:
        try:
            network = make_network(rest, constants)
            break
        except ModelError as error:
            faults.append(error)
            rest = _without(rest, _place(error.where))
    if network is not None:
        faults += [fault for query in document.queries for fault in _query_faults(network, query)]
    return sorted(faults, key=lambda fault: _place(fault.where))


def checked_query(network: Network, query: StoredQuery) -> Query:
    """Parse a stored query and check it against the network.

    Raises:
        ModelError: the query is not well-formed, or refers to something that the network does not have.
    """
    parsed = parse_query(query.formula)
    for condition in (parsed.condition, parsed.then):
        if condition is not None:
            compile_formula(network, condition)
    for target in parsed.targets:
        if compile_clock(network, target) is None:
            compile_integer(network, target)
    return parsed


def _query_faults(network: Network, query: StoredQuery) -> Iterator[ModelError]:
    try:
        checked_query(network, query)
    except ModelError as error:
        yield error


def _place(where: str) -> _Place:
    """Return line and column of ``file:line:column``."""
    found = Diagnostic.at("", where, "")
    return found.line, found.column


def _without(document: Document, place: _Place) -> Document | None:
    """Return the document without the label at a place, or None if no label is there."""
    templates = tuple(_template_without(template, place) for template in document.templates)
    return None if templates == document.templates else replace(document, templates=templates)


def _template_without(template: Template, place: _Place) -> Template:
    edges = (_edge_without(edge, place) for edge in template.edges)
    return replace(
        template,
        locations=tuple(_location_without(location, place) for location in template.locations),
        edges=tuple(edge for edge in edges if edge is not None),
    )


def _location_without(location: DrawnLocation, place: _Place) -> DrawnLocation:
    name = None if location.name is None or _covers(location.name, place) else location.name
    return replace(location, name=name, labels=_labels_without(location.labels, place))


def _edge_without(edge: DrawnEdge, place: _Place) -> DrawnEdge | None:
    labels = _labels_without(edge.labels, place)
    if "select" in edge.labels.keys() - labels.keys():
        return None  # without what it selects, the other labels of an edge have no meaning
    return replace(edge, labels=labels)


def _labels_without(labels: Mapping[str, Label], place: _Place) -> dict[str, Label]:
    return {kind: label for kind, label in labels.items() if not _covers(label, place)}


def _covers(label: Label, place: _Place) -> bool:
    text = label.text
    return _place(text.where(0)) <= place <= _place(text.where(len(text.content)))
