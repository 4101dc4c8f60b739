"""Finds all faults of a UPPAAL file at once, and lists the senders and receivers of its channels.

To find all faults, the label with a fault is removed, and the rest is read again. Removing a label cannot make another
label wrong, so every reported fault is real. A fault in declarations, parameters or the system section ends the
search, because everything else depends on them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from timed_automata.document import Document, DrawnEdge, DrawnLocation, Label, StoredQuery, Template
from timed_automata.errors import Diagnostic, ModelError
from timed_automata.network import Given, Network, make_network
from timed_automata.queries import Query, compile_clock, compile_formula, compile_integer, parse_query

__all__ = ["ChannelEnds", "channel_ends", "checked_query", "find_faults"]


@dataclass(frozen=True, slots=True)
class ChannelEnds:
    """A channel or an array of channels as declared, and the templates at its ends.

    Attributes:
        name: the name, for an array with the number of elements: ``confirmed[3]``.
        broadcast, urgent: as declared.
        senders, receivers: names of templates, in the order of the system line.
        unsent, unreceived: the single channels that no edge sends on, or that no edge receives.
    """

    name: str
    broadcast: bool
    urgent: bool
    senders: tuple[str, ...]
    receivers: tuple[str, ...]
    unsent: tuple[str, ...]
    unreceived: tuple[str, ...]


def channel_ends(network: Network) -> tuple[ChannelEnds, ...]:
    """Return the ends of all channels, in the order of declaration."""
    groups: dict[str, list[int]] = {}
    for number, channel in enumerate(network.channels):
        groups.setdefault(channel.name.partition("[")[0], []).append(number)
    used: dict[str, dict[str, set[int]]] = {"!": {}, "?": {}}  # by direction and template
    for process in network.processes:
        for edge in process.edges:
            if edge.channel is not None:
                used[edge.direction].setdefault(process.template, set()).update(edge.channels)

    def templates(numbers: list[int], direction: str) -> tuple[str, ...]:
        return tuple(name for name, found in used[direction].items() if not found.isdisjoint(numbers))

    def missing(numbers: list[int], direction: str) -> tuple[str, ...]:
        found = set().union(*used[direction].values())
        return tuple(network.channels[n].name for n in numbers if n not in found)

    return tuple(
        ChannelEnds(
            name=name if network.channels[numbers[0]].name == name else f"{name}[{len(numbers)}]",
            broadcast=network.channels[numbers[0]].broadcast,
            urgent=network.channels[numbers[0]].urgent,
            senders=templates(numbers, "!"),
            receivers=templates(numbers, "?"),
            unsent=missing(numbers, "!"),
            unreceived=missing(numbers, "?"),
        )
        for name, numbers in groups.items()
    )


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
