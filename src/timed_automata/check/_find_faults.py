"""All faults of a file: what is found is left out, and the rest is read again.

A label that is left out cannot make another label wrong, so every fault that is reported is one. A fault in
declarations, parameters or the system section ends the search: all else hangs on them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from timed_automata.document import Document, DrawnEdge, DrawnLocation, Label, StoredQuery, Template, Text
from timed_automata.errors import ModelError
from timed_automata.network import Given, Network, make_network
from timed_automata.queries import compile_clock, compile_formula, compile_integer, parse_query

_MOST = 50  # faults: more say nothing new
_Place = tuple[int, int]


def find_faults(document: Document, constants: Mapping[str, Given] | None = None) -> list[ModelError]:
    """Every fault of a document's texts and queries, in the order of the file; none: it is valid.

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


def _query_faults(network: Network, query: StoredQuery) -> Iterator[ModelError]:
    try:
        parsed = parse_query(query.formula)
        for condition in (parsed.condition, parsed.then):
            if condition is not None:
                compile_formula(network, condition)
        for target in parsed.targets:
            if compile_clock(network, target) is None:
                compile_integer(network, target)
    except ModelError as error:
        yield error


def _place(where: str) -> _Place:
    """Line and column of ``file:line:column``."""
    parts = where.rsplit(":", 2)
    if len(parts) == 3 and parts[1].isdigit() and parts[2].isdigit():
        return int(parts[1]), int(parts[2])
    return 0, 0


def _covers(text: Text, place: _Place) -> bool:
    return _place(text.where(0)) <= place <= _place(text.where(len(text.content)))


def _without(document: Document, place: _Place) -> Document | None:
    """The document without the label at a place; None: no label is there."""
    for number, template in enumerate(document.templates):
        changed = _template_without(template, place)
        if changed is not None:
            templates = document.templates
            return replace(document, templates=(*templates[:number], changed, *templates[number + 1 :]))
    return None


def _template_without(template: Template, place: _Place) -> Template | None:
    for number, location in enumerate(template.locations):
        changed = _location_without(location, place)
        if changed is not None:
            locations = template.locations
            return replace(template, locations=(*locations[:number], changed, *locations[number + 1 :]))
    for number, edge in enumerate(template.edges):
        kind = _kind_at(edge.labels, place)
        if kind is not None:
            edges = template.edges
            # without what it selects, the other labels of an edge have no meaning
            kept = () if kind == "select" else (_edge_without(edge, kind),)
            return replace(template, edges=(*edges[:number], *kept, *edges[number + 1 :]))
    return None


def _location_without(location: DrawnLocation, place: _Place) -> DrawnLocation | None:
    if location.name is not None and _covers(location.name.text, place):
        return replace(location, name=None)
    kind = _kind_at(location.labels, place)
    if kind is None:
        return None
    return replace(location, labels={key: label for key, label in location.labels.items() if key != kind})


def _edge_without(edge: DrawnEdge, kind: str) -> DrawnEdge:
    return replace(edge, labels={key: label for key, label in edge.labels.items() if key != kind})


def _kind_at(labels: Mapping[str, Label], place: _Place) -> str | None:
    return next((kind for kind, label in labels.items() if _covers(label.text, place)), None)
