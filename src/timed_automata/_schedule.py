"""When transitions become due: windows of absolute time, from clocks that are known by when they were zero."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from timed_automata._constraints import Bound
from timed_automata._network import State
from timed_automata._outlook import Outlooks, Prospect
from timed_automata._semantics import Transition

ALWAYS, NEVER = -(1 << 62), 1 << 62


class Clocks:
    """Clocks as instants: a clock of value ``c`` at time ``t`` was, or would have been, zero at ``t - c``."""

    def __init__(self, count: int, unit_us: int) -> None:
        self._zero = [0] * count
        self._unit = unit_us

    def start(self, at: int) -> None:
        """All are zero now."""
        self._zero = [at] * len(self._zero)

    @property
    def zeros(self) -> list[int]:
        """When each was zero, by its number."""
        return list(self._zero)

    def resume(self, zeros: list[int]) -> None:
        """Each was zero then."""
        self._zero = list(zeros)

    def set(self, resets: Iterable[tuple[int, int]], at: int) -> None:
        """Clocks get values, in the model's unit."""
        for clock, value in resets:
            self._zero[clock] = at - value * self._unit

    def window(self, bounds: Iterable[Bound]) -> tuple[int, int]:
        """The first and the last instant, in whole µs, at which a conjunction of constraints holds."""
        first, last = ALWAYS, NEVER
        for clock, op, value in bounds:
            instant = self._zero[clock] + value * self._unit
            if op in (">=", ">"):
                first = max(first, instant + (op == ">"))
            else:
                last = min(last, instant - (op == "<"))
        return first, last


class Candidate(NamedTuple):
    """A transition that will be taken if nothing happens before.

    Attributes:
        prospect: the transition, and what it leads to.
        since: when its data guards began to hold.
        first: the instant from which its clock guards hold; ALWAYS without a lower bound.
        due: the later of the two.
        last: the last instant that the model allows.
    """

    prospect: Prospect
    since: int
    first: int
    due: int
    last: int


class Schedule:
    """The candidates of a discrete state, in the order in which those due at the same instant are taken."""

    def __init__(self, outlooks: Outlooks, clocks: Clocks) -> None:
        self._outlooks, self._clocks = outlooks, clocks
        self.candidates: list[Candidate] = []
        self.last = NEVER  # instant until which the invariants allow to stay
        self.committed = False  # whether a process is in a committed location
        self.deadline: int | None = None  # when the first candidate is due
        self.entered = 0  # when the discrete state was entered

    def renew(self, state: State, now: int, taken: Transition | None) -> None:
        """Find the candidates of a state entered now; those that were candidates before keep their age."""
        outlook, self.entered = self._outlooks.at(state), now
        age = {c.prospect.transition.edges: c.since for c in self.candidates}
        if taken:
            age.pop(taken.edges, None)
        _, self.last = self._clocks.window(outlook.stay)
        # invariants that somebody's lateness has broken already: no edge is to blame for that
        expired = outlook.stay if self.last < now else ()
        self.candidates, self.committed, self.deadline = [], outlook.committed, None
        for prospect in outlook.prospects:
            since = age.get(prospect.transition.edges, now)
            first, last = self._clocks.window(prospect.transition.bounds)
            kept = [bound for bound in prospect.kept if bound not in expired] if expired else prospect.kept
            last = min(last, self._clocks.window(kept)[1])
            due = max(first, since)
            if due > last or (due > now and not outlook.may_delay):
                continue
            self.candidates.append(Candidate(prospect, since, first, due, min(last, self.last)))
            if self.deadline is None or due < self.deadline:
                self.deadline = due

    def next(self, until: int, first_before: int = NEVER) -> Candidate | None:
        """What is due first, at or before ``until``; only if its clock guards hold before ``first_before``."""
        if self.deadline is None or self.deadline > until:
            return None
        due = (c for c in self.candidates if c.due <= until and c.first < first_before)
        return min(due, key=lambda candidate: candidate.due, default=None)
