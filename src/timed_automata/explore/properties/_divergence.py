"""Whether time can always pass: a run to where it cannot, or one on which it need not."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from timed_automata.explore.properties._zeno import Taken, zeno_cycle
from timed_automata.explore.search import (
    MOST_DOUBTS,
    DeadlockFree,
    Deadlocks,
    Ending,
    Leg,
    NoRunError,
    Search,
    SearchNode,
    concrete,
)
from timed_automata.explore.states import StateRecord
from timed_automata.network import Trace

NO_TIME = "no transition is possible, and time cannot go on"


class Timelocks:
    """Looks for a deadlock in which time cannot go on either.

    Args:
        search: over a space widened by ExtraLU+, or, ``trusted``, by ExtraM+.
        trusted: whether each deadlock that is found is one; the others are checked once more without widening.
    """

    def __init__(self, search: Search, *, trusted: bool) -> None:
        self.search, self.trusted, self.doubts = search, trusted, 0
        self._deadlock_free, self._deadlocks = DeadlockFree(), Deadlocks()
        self._fine: dict[StateRecord, bool] = {}

    def run(self, nodes: Iterator[SearchNode]) -> Trace | None:
        """The shortest run to one; None: there is none, if no doubts are left.

        Raises:
            OutOfRangeError: a value leaves its range on the way.
        """
        for node in nodes:
            if self._is_fine(node.record) or not self._deadlocks.of(node.record, node.zone):
                continue
            try:
                return concrete(self.search.space, node.legs, self._deadlocks.part, NO_TIME)
            except NoRunError:
                if self.trusted:
                    raise
                self.doubts += 1
                if self.doubts > MOST_DOUBTS:
                    return None
        return None

    def _is_fine(self, record: StateRecord) -> bool:
        fine = self._fine.get(record)
        if fine is None:
            endless = record.discrete.delays and not record.discrete.invariant
            fine = self._fine[record] = endless or self._deadlock_free(record)
        return fine


def taken(records: Iterable[StateRecord]) -> Iterator[Taken]:
    """The transitions that a search has taken."""
    for record in records:
        zones = [node.zone for node in record.passed]
        for plan, target, move in record.steps if zones else ():
            for zone in zones:
                if plan(zone) is not None:
                    yield record, target, move
                    break


def zeno_run(search: Search, arcs: list[Taken]) -> Trace | None:
    """A run to a cycle on which no time needs to pass, and once round, after a whole search."""
    cycle = zeno_cycle(arcs)
    if cycle is None:
        return None
    anywhere: Ending = lambda _, zone: zone  # noqa: E731
    moves = [Leg(one.move) for one in cycle]
    remark = "a cycle on which no time needs to pass"
    for node in cycle[0].source.passed:
        try:
            loop = len(node.legs) - 1
            return concrete(search.space, [*node.legs, *moves], anywhere, remark, loop=loop)
        except NoRunError:  # not from this zone
            continue
    return concrete(search.space, cycle[0].source.passed[0].legs, anywhere, f"here begins {remark}")
