"""A symbolic state that a search has reached."""

from __future__ import annotations

from timed_automata.explore.search._concrete import Leg
from timed_automata.explore.states import Move, StateRecord
from timed_automata.explore.zones import Zone


class SearchNode:
    """A symbolic state that was reached, and how."""

    __slots__ = ("covered", "move", "parent", "record", "zone")

    def __init__(self, record: StateRecord, zone: Zone, parent: SearchNode | None, move: Move | None) -> None:
        self.record, self.zone, self.parent, self.move = record, zone, parent, move
        self.covered = False

    @property
    def legs(self) -> list[Leg]:
        """The run from the initial state to here."""
        legs = []
        node: SearchNode | None = self
        while node is not None:
            legs.append(Leg(node.move))
            node = node.parent
        return legs[::-1]
