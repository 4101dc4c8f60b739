"""What the edges of a transition do together, found once: many transitions have the same."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from timed_automata.compiler import Bound
from timed_automata.explore.states._location_vector import LocationVector, LocationVectors
from timed_automata.explore.states._packing import Packing
from timed_automata.network import Edge

Fixed = Sequence[tuple[str, int, int]]
Resets = tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Action:
    """What a transition does to clocks, and who takes part; one object for all transitions that are alike.

    Attributes:
        edges: participants, the sender first.
        channel: number of the channel; None without synchronisation.
        guard: what the clocks must satisfy.
        resets: what they are set to.
    """

    edges: tuple[Edge, ...]
    channel: int | None
    guard: tuple[Bound, ...]
    resets: Mapping[int, int]


class Firing:
    """Some edges that are taken together.

    Args:
        edges: them, the sender first.
        vectors: of the network.
        packing: of its values.
        fixed: variable, offset and value of the variables that nothing reads: they keep their value.
    """

    __slots__ = ("_actions", "_after", "_edges", "_fixed", "_packing", "_targets", "_updates", "_vectors")

    def __init__(
        self, edges: tuple[Edge, ...], vectors: LocationVectors, packing: Packing, fixed: Fixed
    ) -> None:
        written: Collection[str] = {name for edge in edges for name in edge.effects.writes}
        self._edges, self._vectors, self._packing = edges, vectors, packing
        self._targets = [(edge.process, edge.target) for edge in edges]
        self._updates = [edge.update for edge in edges if edge.update is not None]
        self._fixed = [(offset, value) for name, offset, value in fixed if name in written]
        self._after: dict[LocationVector, LocationVector] = {}
        self._actions: dict[object, Action] = {}

    def __call__(self, vector: LocationVector, packed: bytes) -> tuple[LocationVector, bytes, Resets]:
        """The next discrete state, and the clocks that are set, in order, with their values.

        Raises:
            RangeError: an assignment is out of range.
        """
        after = self._after.get(vector)
        if after is None:
            after = self._after[vector] = self._vectors.moved(vector, self._targets)
        if not self._updates:
            return after, packed, ()
        resets: list[tuple[int, int]] = []
        values = self._packing.open(packed)
        for update in self._updates:
            update(values, resets)
        for offset, value in self._fixed:
            values[offset] = value
        return after, values.tobytes(), tuple(resets)

    def action(self, guard: tuple[Bound, ...], channel: int | None, resets: Resets) -> Action:
        """The action of a transition with these edges."""
        key = (guard, channel, resets)
        found = self._actions.get(key)
        if found is None:
            found = self._actions[key] = Action(self._edges, channel, guard, dict(resets))
        return found
