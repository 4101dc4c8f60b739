"""What the edges of a transition do together, found once: many transitions have the same."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from end_effector_hal.automata._network import Edge, State
from end_effector_hal.automata._semantics import Fired

Fixed = Sequence[tuple[str, int, int]]


class Firing:
    """Some edges that are taken together.

    Args:
        edges: them, the sender first.
        fixed: variable, offset and value of what nobody reads: it stays as it is.
    """

    __slots__ = ("_after", "_fixed", "_targets", "_updates")

    def __init__(self, edges: Sequence[Edge], fixed: Fixed) -> None:
        written: Collection[str] = {name for edge in edges for name in edge.effects.writes}
        self._targets = [(edge.process, edge.target) for edge in edges]
        self._updates = [edge.update for edge in edges if edge.update is not None]
        self._fixed = [(offset, value) for name, offset, value in fixed if name in written]
        self._after: dict[tuple[int, ...], tuple[int, ...]] = {}

    def __call__(self, state: State) -> Fired:
        """The next state, and the clocks that are set.

        Raises:
            RangeError: an assignment is out of range.
        """
        locations, values = state
        after = self._after.get(locations)
        if after is None:
            moved = list(locations)
            for process, target in self._targets:
                moved[process] = target
            after = self._after[locations] = tuple(moved)
        resets: list[tuple[int, int]] = []
        if self._updates:
            changed = list(values)
            for update in self._updates:
                update(changed, resets)
            for offset, value in self._fixed:
                changed[offset] = value
            values = tuple(changed)
        return Fired(State(after, values), tuple(resets))
