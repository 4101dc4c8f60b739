"""Staying in a discrete state: whether time may pass, and until when. What depends on locations is found once."""

from __future__ import annotations

from typing import NamedTuple

from end_effector_hal.automata._constraints import Bound, ClockConstraint
from end_effector_hal.automata._network import Network, State


class _Rest(NamedTuple):
    """Of the locations of all processes: whether time passes, the invariant where it is fixed, else its parts."""

    locations: tuple[int, ...]
    delays: bool
    fixed: tuple[Bound, ...] | None
    parts: tuple[ClockConstraint, ...]


class Resting:
    """For a network, whatever its urgent channels do."""

    def __init__(self, network: Network) -> None:
        self._network = network
        self._known: dict[tuple[int, ...], _Rest] = {}
        self._shared: dict[tuple[Bound, ...], tuple[Bound, ...]] = {}

    def at(self, state: State) -> tuple[bool, tuple[Bound, ...]]:
        """Whether no urgent or committed location stops time, and the invariant."""
        locations, values = state
        rest = self._known.get(locations)
        if rest is None:
            rest = self._known[locations] = self._rest(locations)
        if rest.fixed is not None:
            return rest.delays, rest.fixed
        bounds = tuple(part.at(values) for part in rest.parts)
        return rest.delays, self._shared.setdefault(bounds, bounds)

    def shared(self, state: State) -> State:
        """The same state; equal locations are one object."""
        rest = self._known.get(state.locations)
        return state if rest is None else State(rest.locations, state.values)

    def _rest(self, locations: tuple[int, ...]) -> _Rest:
        processes = zip(self._network.processes, locations, strict=True)
        found = [process.locations[at] for process, at in processes]
        parts = tuple(part for location in found for part in location.invariant.clocks)
        known = tuple(bound for part in parts if (bound := part.fixed) is not None)
        fixed = known if len(known) == len(parts) else None
        return _Rest(locations, not any(at.urgent or at.committed for at in found), fixed, parts)
