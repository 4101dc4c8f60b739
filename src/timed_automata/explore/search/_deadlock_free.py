"""Discrete states without a deadlock, whatever the clocks say: they need no search for deadlocks."""

from __future__ import annotations

from timed_automata.explore.search._deadlock import enabling, enabling_key
from timed_automata.explore.states import StateRecord
from timed_automata.explore.zones import Constraint, Zone, constrained, down, everything, included


class DeadlockFree:
    """Whether one transition is enabled, now or later, from every valuation that the invariant allows."""

    def __init__(self) -> None:
        self._known: dict[object, bool] = {}

    def __call__(self, record: StateRecord) -> bool:
        """Sufficient, not necessary: several transitions may do so together."""
        for step in record.steps:
            key = enabling_key(record, step)
            always = self._known.get(key)
            if always is None:
                needed = enabling(record, step)
                always = needed is not None and _always(
                    record.n, record.discrete.delays, record.invariant, needed
                )
                self._known[key] = always
            if always:
                return True
        return False


def _always(n: int, delays: bool, invariant: tuple[Constraint, ...], needed: tuple[Constraint, ...]) -> bool:
    inside: Zone | None = constrained(everything(n), n, invariant)
    way: Zone | None = constrained(everything(n), n, needed)
    if inside is None or way is None:
        return inside is None
    return included(inside, down(way, n) if delays else way)
