"""Whether time can always pass: a run to where it cannot, or one on which it need not."""

from __future__ import annotations

from collections.abc import Iterator

from timed_automata.explore._concrete import Ending, Leg, NoRunError, concrete
from timed_automata.explore._deadlock import Deadlocks
from timed_automata.explore._goes_on import GoesOn
from timed_automata.explore._reach import Node, Search
from timed_automata.explore._symbolic import Place
from timed_automata.explore._trace import Trace
from timed_automata.explore._zeno import Taken, zeno_cycle
from timed_automata.explore._zone import Zone

MOST_DOUBTS = 20  # deadlocks that turn out not to be: then a finer search is cheaper


class Timelocks:
    """Looks for a deadlock in which time cannot go on either.

    Args:
        search: over a space widened by ExtraLU+, or, ``trusted``, by ExtraM+.
        trusted: whether each deadlock that is found is one; the others are checked once more without widening.
    """

    def __init__(self, search: Search, *, trusted: bool) -> None:
        self.search, self.trusted, self.doubts = search, trusted, 0
        self._goes_on, self._deadlocks = GoesOn(), Deadlocks()
        self._fine: dict[Place, bool] = {}

    def run(self, nodes: Iterator[Node]) -> Trace | None:
        """The shortest run to one; None: there is none, if no doubts are left.

        Raises:
            OutOfRangeError: a value leaves its range on the way.
        """
        remark = "no transition is possible, and time cannot go on"
        for node in nodes:
            if self._is_fine(node.place) or not self._deadlocks.of(node.place, node.zone):
                continue
            try:
                return concrete(self.search.space, node.legs, self._ending, remark)
            except NoRunError:
                if self.trusted:
                    raise
                self.doubts += 1
                if self.doubts > MOST_DOUBTS:
                    return None
        return None

    def _is_fine(self, place: Place) -> bool:
        fine = self._fine.get(place)
        if fine is None:
            endless = place.discrete.delays and not place.discrete.invariant
            fine = self._fine[place] = endless or self._goes_on(place)
        return fine

    def _ending(self, place: Place, zone: Zone) -> Zone | None:
        return next(iter(self._deadlocks.of(place, zone)), None)


def taken(places: Iterator[Place]) -> Iterator[Taken]:
    """The transitions that a search has taken."""
    for place in places:
        zones = [node.zone for node in place.passed]
        for plan, target, move in place.steps if zones else ():
            for zone in zones:
                if plan(zone) is not None:
                    yield place, target, move
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
