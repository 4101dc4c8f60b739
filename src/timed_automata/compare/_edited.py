"""Where an edited network differs: in all other states it has the moves of the network that was edited."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from typing import NamedTuple

from timed_automata.network import Network, Process


class EditedPlaces(NamedTuple):
    """The locations of a process in which it may do otherwise."""

    process: int
    locations: frozenset[int]


def edited_places(network: Network, edited: Network) -> tuple[EditedPlaces, ...] | None:
    """Where a network does not have the edges and locations of an edited one, if both share what was not edited.

    None: it may be anywhere.
    """
    ours, theirs = network.document, edited.document
    declared = (
        (
            document.declarations,
            document.system,
            document.instantiations,
            [(each.name, each.declarations, each.parameters) for each in document.templates],
        )
        for document in (ours, theirs)
    )
    if network.constants != edited.constants or next(declared) != next(declared):
        return None
    return tuple(
        EditedPlaces(one.index, places)
        for one, other in zip(network.processes, edited.processes, strict=True)
        if (places := frozenset(chain(_differing(one, other), _differing(other, one))))
    )


def _differing(process: Process, other: Process) -> Iterator[int]:
    """The locations of a process that another one does not have, or has without one of their edges."""
    locations, edges = ({id(each.drawn) for each in parts} for parts in (other.locations, other.edges))
    changed = {each.index for each in process.locations if id(each.drawn) not in locations}
    yield from changed
    yield from (
        edge.source for edge in process.edges if id(edge.drawn) not in edges or edge.target in changed
    )
