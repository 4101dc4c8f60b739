"""Computes when transitions are due, and the order of those that are due at the same instant."""

from __future__ import annotations

from typing import NamedTuple

from timed_automata.execute._successors import ALWAYS, NEVER, ClockInstants, Successor, SuccessorCache
from timed_automata.network import Edge, State, Transition


class ScheduledTransition(NamedTuple):
    """A transition that will be taken unless an event comes first.

    Attributes:
        successor: the transition and its result.
        first: the instant from which its clock guards hold; ALWAYS without a lower bound.
        due: the later of ``first`` and the instant since which its data guards hold.
        last: the last instant that the model allows.
    """

    successor: Successor
    first: int
    due: int
    last: int


class Schedule:
    """The candidate transitions of a discrete state, in the order in which those due at the same instant are taken."""

    def __init__(self, cache: SuccessorCache, clocks: ClockInstants) -> None:
        self._successors, self._clocks = cache, clocks
        self.candidates: list[ScheduledTransition] = []
        self._since: dict[tuple[Edge, ...], int] = {}  # when the data guards of the candidates began to hold
        self.last = NEVER  # instant until which the invariants allow to stay
        self.committed = False  # whether a process is in a committed location
        self.deadline: int | None = None  # when the first candidate is due
        self.entered = 0  # when the discrete state was entered

    def copy(self, clocks: ClockInstants) -> Schedule:
        """Return a schedule with the same candidates that reads other clocks."""
        new = Schedule(self._successors, clocks)
        new.candidates, new._since = self.candidates, dict(self._since)
        new.last, new.committed, new.deadline, new.entered = (
            self.last,
            self.committed,
            self.deadline,
            self.entered,
        )
        return new

    def renew(self, state: State, now: int, taken: Transition | None) -> None:
        """Find the candidates of a state entered now; transitions that were candidates before keep their age."""
        found, self.entered = self._successors.known.get(state) or self._successors.at(state), now
        before, self._since = self._since, {}
        if taken:
            before.pop(taken.edges, None)
        self.last = self._clocks.window(found.stay)[1] if found.stay else NEVER
        # invariants that earlier lateness has broken already: they say nothing against an edge
        expired = found.stay if self.last < now else ()
        self.candidates, self.committed, self.deadline = [], found.committed, None
        for successor in found.successors:
            edges = successor.transition.edges
            since = before.get(edges, now)
            bounds = successor.bounds_without(expired) if expired else successor.bounds
            first, last = self._clocks.window(bounds) if bounds else (ALWAYS, NEVER)
            due = max(first, since)
            if due > last or (due > now and not found.may_delay):
                continue
            self._since[edges] = since
            self.candidates.append(ScheduledTransition(successor, first, due, min(last, self.last)))
            if self.deadline is None or due < self.deadline:
                self.deadline = due

    def next(self, until: int, first_before: int = NEVER) -> ScheduledTransition | None:
        """Return the candidate due first, at or before ``until``, whose clock guards hold before ``first_before``; or
        None. The deadline must not be after ``until``.
        """
        earliest: ScheduledTransition | None = None
        for candidate in self.candidates:
            if candidate.due <= until and candidate.first < first_before:
                if candidate.due == self.deadline:
                    return candidate
                if earliest is None or candidate.due < earliest.due:
                    earliest = candidate
        return earliest
