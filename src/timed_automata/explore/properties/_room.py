"""Checks that executed templates have room for a late reaction: time-outs are due early enough before an invariant
ends.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from timed_automata.compiler import Bound
from timed_automata.explore.states import StateRecord
from timed_automata.network import Edge, Network, Process


@dataclass(frozen=True, slots=True)
class ReactionBound:
    """The executed templates, and their longest lateness.

    Attributes:
        executed: names of the templates that a program executes.
        room: longest lateness of an edge, in the model's unit of time.
    """

    executed: Collection[str]
    room: int


class Room:
    """Checks the time-outs of the locations that a search reaches.

    A location with an invariant ``c <= b`` needs an edge without a receiving synchronisation that is enabled from ``c
    >= b - room`` on: with less room a late program violates the bound, with more room a later reaction goes unnoticed.
    """

    def __init__(self, network: Network, reaction: ReactionBound) -> None:
        self._room = reaction.room
        self._timed = [
            (
                process,
                {
                    at: self._edges(process, at)
                    for at, each in enumerate(process.locations)
                    if each.invariant.clocks
                },
            )
            for process in network.processes
            if process.template in reaction.executed
        ]
        self._found: dict[str, None] = {}

    @staticmethod
    def _edges(process: Process, location: int) -> list[Edge]:
        return [edge for edge in process.edges if edge.source == location and edge.direction != "?"]

    def add(self, record: StateRecord) -> None:
        """Check a state that was reached; a state in which time cannot pass has no requirement."""
        if not record.discrete.delays:
            return
        state = record.discrete.state
        for process, timed in self._timed:
            at = state.locations[process.index]
            if at in timed:
                for constraint in process.locations[at].invariant.clocks:
                    self._judge(process, at, constraint.at(state.values), timed[at], state.values)

    def _judge(
        self, process: Process, at: int, most: Bound, edges: list[Edge], values: tuple[int, ...]
    ) -> None:
        latest = most.value - (most.op == "<") - self._room
        firsts = [_first(edge, most.clock, values) for edge in edges if edge.guard.holds(values)]
        if latest not in firsts:
            location = process.locations[at]
            left = most.value - (most.op == "<") - min(firsts, default=most.value)
            what = f"{left} instead of {self._room}" if firsts else "no edge is due"
            self._found[f"{process.template}.{location.name}: {what}"] = None

    @property
    def missing(self) -> tuple[str, ...]:
        """Locations that leave more or less room than required, in words."""
        return tuple(self._found)


def _first(edge: Edge, clock: int, values: tuple[int, ...]) -> int:
    """Return the value of the clock from which the edge is enabled."""
    bounds = [each.at(values) for each in edge.guard.clocks]
    lower = [b.value + (b.op == ">") for b in bounds if b.clock == clock and b.op in (">", ">=", "==")]
    return max(lower, default=0)
