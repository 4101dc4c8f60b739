"""A symbolic state that a search has reached."""

from __future__ import annotations

from timed_automata.explore.search._concrete import Leg
from timed_automata.explore.states import Action, Move, StateRecord
from timed_automata.explore.zones import Zone, packed


class SearchNode:
    """A reached symbolic state, with its predecessor and the action that led to it."""

    __slots__ = ("_packed", "action", "covered", "parent", "record", "zone")

    def __init__(
        self, record: StateRecord, zone: Zone, parent: SearchNode | None, action: Action | None
    ) -> None:
        self.record, self.zone, self.parent, self.action = record, zone, parent, action
        self.covered, self._packed = False, 0

    @property
    def packed(self) -> int:
        """The zone packed into one integer, computed at first use."""
        if not self._packed:
            self._packed = packed(self.zone)
        return self._packed

    @property
    def move(self) -> Move | None:
        """The last move of the run to this state."""
        return None if self.action is None else Move(self.action, self.record.discrete)

    @property
    def legs(self) -> list[Leg]:
        """The legs of the run from the initial state to this state."""
        legs = []
        node: SearchNode | None = self
        while node is not None:
            legs.append(Leg(node.move))
            node = node.parent
        return legs[::-1]
