"""When transitions become due: windows of absolute time, from clocks that are known by when they were zero."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import NamedTuple

from end_effector_hal.automata._constraints import Bound
from end_effector_hal.automata._network import State
from end_effector_hal.automata._semantics import Fired, Semantics, Transition
from end_effector_hal.errors import RangeError

ALWAYS, NEVER = -(1 << 62), 1 << 62


class Clocks:
    """Clocks as instants: a clock of value ``c`` at time ``t`` was, or would have been, zero at ``t - c``."""

    def __init__(self, count: int, unit_us: int) -> None:
        self._zero = [0] * count
        self._unit = unit_us

    def start(self, at: int) -> None:
        """All are zero now."""
        self._zero = [at] * len(self._zero)

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
        since: when its data guards began to hold.
        first: the instant from which its clock guards hold; ALWAYS without a lower bound.
        due: the later of the two.
        last: the last instant that the model allows.
        fired: what it leads to, or why it cannot.
    """

    transition: Transition
    since: int
    first: int
    due: int
    last: int
    fired: Fired | RangeError


class Schedule:
    """The candidates of a discrete state, in the order in which those due at the same instant are taken."""

    def __init__(self, semantics: Semantics, clocks: Clocks) -> None:
        self._semantics, self._clocks = semantics, clocks
        self.candidates: list[Candidate] = []
        self.last = NEVER  # instant until which the invariants allow to stay

    def renew(self, state: State, now: int, taken: Transition | None) -> None:
        """Find the candidates of a state entered now; those that were candidates before keep their age."""
        age = {c.transition.edges: c.since for c in self.candidates}
        if taken:
            age.pop(taken.edges, None)
        stay = self._semantics.invariant(state)
        _, self.last = self._clocks.window(stay)
        hurry = not self._semantics.may_delay(state)
        self.candidates = []
        for transition in self._semantics.transitions(state):
            since = age.get(transition.edges, now)
            candidate = self._candidate(state, transition, since, stay if self.last < now else ())
            if candidate and not (hurry and candidate.due > now):
                self.candidates.append(candidate)

    def _candidate(
        self, state: State, transition: Transition, since: int, expired: Collection[Bound]
    ) -> Candidate | None:
        """``expired``: invariants that somebody's lateness has broken already; no edge is to blame for that."""
        first, last = self._clocks.window(transition.bounds)
        fired: Fired | RangeError
        try:
            fired = self._semantics.fire(state, transition.edges)
            invariant = self._semantics.invariant(fired.state)
        except RangeError as error:  # told when the edge is due, if ever
            fired = error
        else:
            values = dict(fired.resets)
            if not all(_holds(values[bound.clock], bound) for bound in invariant if bound.clock in values):
                return None
            kept = (b for b in invariant if b.clock not in values and b not in expired)
            last = min(last, self._clocks.window(kept)[1])
        due = max(first, since)
        if due > last:
            return None
        return Candidate(transition, since, first, due, min(last, self.last), fired)

    @property
    def deadline(self) -> int | None:
        """When the first candidate is due."""
        return min((candidate.due for candidate in self.candidates), default=None)

    def next(self, until: int, first_before: int = NEVER) -> Candidate | None:
        """What is due first, at or before ``until``; only if its clock guards hold before ``first_before``."""
        due = (c for c in self.candidates if c.due <= until and c.first < first_before)
        return min(due, key=lambda candidate: candidate.due, default=None)


def _holds(value: int, bound: Bound) -> bool:
    return value < bound.value or (value == bound.value and bound.op == "<=")
