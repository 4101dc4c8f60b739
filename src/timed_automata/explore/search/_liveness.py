"""Finds runs that stay inside a condition without end: they show ``E[]``, and refute ``A<>`` and ``-->``.

UPPAAL's semantics: such a run is infinite (time need not diverge), or it ends where time can pass without end, or
where no transition is possible any more. States with different zones count as different: inclusion would find false
cycles. ExtraLU+ keeps infinite runs (Li, *Checking Timed Büchi Automata Emptiness Using LU-Abstractions*, 2009), but
not the ends of finite ones: those are checked once more without widening, and with ExtraM+ if a doubt remains.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from typing import NamedTuple

from timed_automata.errors import RangeError
from timed_automata.explore.search._concrete import Ending, Leg, anywhere
from timed_automata.explore.search._conditions import Within
from timed_automata.explore.search._cycles import components, shortest_cycle
from timed_automata.explore.search._deadlock import MOST_DOUBTS, Deadlocks
from timed_automata.explore.search._reach import EVERY, OutOfRangeError, Progress
from timed_automata.explore.states import Move, StateRecord, SymbolicSpace
from timed_automata.explore.states._discrete import Action
from timed_automata.explore.zones import Zone, constrained, constraints_of, included, subtract
from timed_automata.explore.zones._zone import down, everything, unbounded


class Start(NamedTuple):
    """A start of runs: a zone at entry (no time has passed yet), and the legs that lead to it."""

    record: StateRecord
    zone: Zone
    legs: tuple[Leg, ...]


class LassoState:
    """A symbolic state inside the condition; ``parent`` is None for a start."""

    __slots__ = ("action", "depth", "following", "parent", "record", "start", "zone")

    def __init__(
        self, record: StateRecord, zone: Zone, parent: LassoState | None, action: Action | None, start: Start
    ) -> None:
        self.record, self.zone, self.parent, self.action, self.start = record, zone, parent, action, start
        self.depth: int = parent.depth + 1 if parent else 0
        self.following: list[tuple[Action, LassoState]] = []


class Lasso(NamedTuple):
    """A run that stays: its legs, the condition on its end, why it lasts, and the move to which it returns."""

    legs: list[Leg]
    ending: Ending
    remark: str
    loop: int | None


class LassoSearch:
    """Searches for a run that stays inside a condition. ``space`` must not let zones grow by itself.

    Args:
        space: the space to search.
        within: the condition.
        confirmed: returns whether a run that ends is a run of the network; not called for endless runs. None: all are.
        progress: called now and then with the number of states.
    """

    def __init__(
        self,
        space: SymbolicSpace,
        within: Within,
        confirmed: Callable[[Lasso], bool] | None = None,
        progress: Progress | None = None,
    ) -> None:
        self.space, self.within, self._progress = space, within, progress
        self.states = self.doubts = 0
        self._confirmed = confirmed
        self._deadlocks = Deadlocks()
        self._known: dict[tuple[StateRecord, Zone], LassoState] = {}  # of the start at hand
        self._safe: dict[StateRecord, list[Zone]] = {}  # from which no run stays: of the starts before

    def lasso(self, starts: Iterable[Start]) -> Lasso | None:
        """Return a run that stays inside the condition without end, from any of the starts, or None if there is none.

        Raises:
            OutOfRangeError: a value leaves its range on the way.
        """
        for start in starts:
            found = self._from(start)
            if found is not None or self.doubts > MOST_DOUBTS:
                return found
            for record, zone in self._known:
                zones = self._safe.setdefault(record, [])
                if not any(included(zone, other) for other in zones):
                    zones[:] = [other for other in zones if not included(other, zone)]
                    zones.append(zone)
            self._known = {}
        return None

    def _from(self, start: Start) -> Lasso | None:
        waiting: deque[LassoState] = deque()
        for _, zone in self.within(start.record, start.zone):
            self._reach(start.record, zone, None, None, start, waiting)
        while waiting:
            state = waiting.popleft()
            end = self._end(state)
            if end is not None:
                if self._confirmed is None or self._confirmed(end):
                    return end
                self.doubts += 1
                if self.doubts > MOST_DOUBTS:
                    return None
            try:
                steps = state.record.steps
            except RangeError as error:
                raise OutOfRangeError(error, self._legs(state)) from None
            for plan, target, move in steps:
                entered = plan(state.zone)
                if entered is None:
                    continue
                if move.error is not None:
                    raise OutOfRangeError(move.error, [*self._legs(state), Leg(move)])
                for _, zone in self.within(target, entered):
                    found = self._reach(target, zone, state, move.action, start, waiting)
                    if found is not None:
                        state.following.append((move.action, found))
        return self._cycle() if self._known else None

    def _reach(
        self,
        record: StateRecord,
        zone: Zone,
        parent: LassoState | None,
        action: Action | None,
        start: Start,
        waiting: deque[LassoState],
    ) -> LassoState | None:
        known = self._known.get((record, zone))
        if known is None:
            if any(included(zone, safe) for safe in self._safe.get(record, ())):
                return None
            known = self._known[record, zone] = LassoState(record, zone, parent, action, start)
            self.states += 1
            if self._progress is not None and not self.states % EVERY:
                self._progress(self.states)
            waiting.append(known)
        return known

    def _legs(self, state: LassoState) -> list[Leg]:
        moves: list[Leg] = []
        at: LassoState | None = state
        while at is not None and at.action is not None:
            moves.append(self._leg(at.action, at))
            at = at.parent
        return [*state.start.legs, Leg(None, self.within), *reversed(moves)]

    def _leg(self, action: Action, to: LassoState) -> Leg:
        return Leg(Move(action, to.record.discrete), self.within)

    def _end(self, state: LassoState) -> Lasso | None:
        record, zone = state.record, state.zone
        if record.discrete.delays and unbounded(zone, record.n):
            return Lasso(self._legs(state), _endless, "from here time can pass without end", None)
        if self._stuck(record, zone) is not None:
            return Lasso(self._legs(state), self._stuck, "from here nothing can happen any more", None)
        return None

    def _stuck(self, record: StateRecord, zone: Zone) -> Zone | None:
        """Return the part where no transition is possible, now or later, and from where time does not lead outside; or
        None.
        """
        left, n = self._deadlocks.of(record, zone), record.n
        if left and record.discrete.delays:
            for constraints, _ in self.within.outside.of(record):
                outside = constrained(everything(n), n, (*constraints, *record.invariant))
                if outside is not None:
                    way = constraints_of(down(outside, n), n)
                    left = [piece for part in left for piece in subtract(part, way, n)]
        return left[0] if left else None

    def _cycle(self) -> Lasso | None:
        """Return the cycle that is reached first, after all states are known and none ends a run."""
        graph = {state: [other for _, other in state.following] for state in self._known.values()}
        on_cycles = [state for component in components(graph) for state in component]
        if not on_cycles:
            return None
        state = min(on_cycles, key=lambda state: state.depth)
        legs = self._legs(state)
        loop = sum(leg.move is not None for leg in legs)
        following = shortest_cycle(state, lambda at: (((action, to), to) for action, to in at.following))
        legs += [self._leg(action, to) for action, to in following]
        return Lasso(legs, anywhere, "repeats indefinitely", loop)


def _endless(record: StateRecord, zone: Zone) -> Zone | None:
    return zone if unbounded(zone, record.n) else None
