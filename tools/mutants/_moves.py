"""The moves out of a discrete state of one of two networks, in a form that both networks share."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from timed_automata.compiler import Bound
from timed_automata.explore.states import DiscreteState


class ComparedMove(NamedTuple):
    """A move without references to objects of its network.

    Attributes:
        channel: number of the channel; None: no synchronisation.
        bounds: the conditions on the clocks: the guard, and the invariant of the target.
        resets: clocks with their new values, in order.
        target: the discrete state.
    """

    channel: int | None
    bounds: tuple[Bound, ...]
    resets: tuple[tuple[int, int], ...]
    target: DiscreteState

    @property
    def plain(self) -> tuple[object, ...]:
        """The properties that equivalent moves share for all clock values."""
        return self.channel, self.bounds, self.resets, place(self.target), self.target.invariant


def place(state: DiscreteState) -> tuple[tuple[int, ...], bytes]:
    """Return locations and values, which are comparable between the networks."""
    return state.vector.locations, state.packed


def moves_of(state: DiscreteState) -> Iterator[ComparedMove]:
    """Return all moves, for any clock values.

    Raises:
        RangeError: a guard or an update leaves a range.
    """
    for action, target, error in state.moves:
        if target is None:
            assert error is not None
            raise error
        bounds, resets = list(action.guard), action.resets
        for bound in target.invariant:
            if bound.clock not in resets:
                bounds.append(bound)
            elif not bound.allows(resets[bound.clock]):
                break
        else:
            yield ComparedMove(action.channel, tuple(bounds), tuple(sorted(resets.items())), target)
