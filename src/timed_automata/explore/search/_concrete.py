"""Converts a symbolic run to a concrete one with absolute times."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import NamedTuple

from timed_automata.compiler import Bound
from timed_automata.explore.search._conditions import Grow, freely
from timed_automata.explore.states import Move, StateRecord, SymbolicSpace
from timed_automata.explore.zones import AT_MOST_ZERO, INFINITY, Zone, constraints_of
from timed_automata.explore.zones._zone import at_most, below
from timed_automata.network import Trace, TraceStep, changes_between

_MARGINS = tuple(Fraction(1, parts) for parts in (1, 2, 5, 10, 100, 1000))  # by which strict bounds are kept
Ending = Callable[[StateRecord, Zone], Zone | None]


def anywhere(_: StateRecord, zone: Zone) -> Zone | None:
    """Accept the whole zone as the ending of a run."""
    return zone


class NoRunError(Exception):
    """The legs do not form a run."""


class Leg(NamedTuple):
    """A part of a run: a move, then a delay; without a move (None), another rule for delays holds from here on."""

    move: Move | None
    grow: Grow = freely


class _Visit(NamedTuple):
    """A leg among exact zones: the record, the zone at entry, and the zone after a delay."""

    record: StateRecord
    entry: Zone | None  # None: anywhere
    later: Zone | None


def concrete(
    space: SymbolicSpace, legs: Sequence[Leg], ending: Ending, remark: str, *, loop: int | None = None
) -> Trace:
    """Return the earliest run along the legs whose end satisfies ``ending``.

    Args:
        space: the space in which the run was found.
        legs: the first one has no move and starts in the initial state.
        ending: returns the part of the last zone that satisfies the condition.
        remark: description of the end of the run.
        loop: number of the move to which the run returns.

    Raises:
        NoRunError: there is none; never for legs that a search has found.

    A run found among widened zones is real (every valuation that widening adds is simulated by an original one), so
    the zones along it are computed once more without widening.
    """
    exact = SymbolicSpace(space.discrete, space.limits, delays=False, widens=False)
    record, zone = exact.initial()
    visits = _follow(exact, record, zone, list(legs), ending)
    if visits is None:
        raise NoRunError
    timing, instants = Timing(), []
    for leg, visit in zip(legs, visits, strict=True):
        if leg.move is not None:
            timing.require(leg.move.action.guard)
            for clock, value in leg.move.action.resets.items():
                timing.set(clock, value)
            instants.append(timing.now)
        timing.require(visit.record.form.entry)
        _require(timing, visit.record, visit.entry)
        timing.advance(delays=visit.record.discrete.delays)
        timing.require(visit.record.discrete.invariant)
        _require(timing, visit.record, visit.later)
    times = timing.solve()
    network, state, steps = space.discrete.network, record.discrete.state, []
    for move, instant in zip((leg.move for leg in legs if leg.move is not None), instants, strict=True):
        if move.target is None:
            break
        edges, number, after = move.action.edges, move.action.channel, move.target.state
        channel = None if number is None else network.channels[number].name
        steps.append(TraceStep(times[instant], channel, edges, after, changes_between(network, state, after)))
        state = after
    return Trace(network, tuple(steps), times[-1], remark, loop)


def _require(timing: Timing, record: StateRecord, zone: Zone | None) -> None:
    if zone is not None:
        numbers = (0, *record.form.clocks)
        for i, j, bound in constraints_of(zone, record.n):
            timing.require_difference(numbers[i], numbers[j], bound)


def _follow(
    space: SymbolicSpace, record: StateRecord, zone: Zone, legs: list[Leg], ending: Ending
) -> list[_Visit] | None:
    """Return the exact zones of a run; where a condition leaves several ways to stay, the first that leads
    to the end.
    """
    pending: list[tuple[list[_Visit], StateRecord, Zone]] = [([], record, zone)]
    while pending:
        visits, record, zone = pending.pop()
        leg = legs[len(visits)]
        arrived: Zone | None = zone
        if leg.move is not None:
            plan, record, _ = space.step(record, leg.move)
            arrived = plan(zone)
        if arrived is None:
            continue
        free = leg.grow is freely
        more: list[tuple[list[_Visit], StateRecord, Zone]] = []
        for entry, later in leg.grow(record, arrived):
            if len(visits) + 1 < len(legs):
                visit = _Visit(record, None if free else entry, None if free else later)
                more.append(([*visits, visit], record, later))
            elif (part := ending(record, later)) is not None:
                return [*visits, _Visit(record, None if free else entry, part)]
        pending += reversed(more)
    return None


@dataclass(slots=True)
class Timing:
    """The times of the transitions of a symbolic run: a system of differences, solved for the earliest times.

    The unknowns are the instants of the run in order; the first is 0, when all clocks are zero. A clock is stored as
    an instant and the value set then: its value at another instant is that value plus the difference of the instants.
    """

    _set: dict[int, tuple[int, int]] = field(default_factory=dict)
    _bounds: list[tuple[int, int, int]] = field(default_factory=list)  # (a, b, bound): a - b within bound
    now: int = 0

    def advance(self, *, delays: bool) -> None:
        """Start the next instant, at the same time as the last one unless time may pass."""
        self.now += 1
        self._bounds.append((self.now - 1, self.now, AT_MOST_ZERO))
        if not delays:
            self._bounds.append((self.now, self.now - 1, AT_MOST_ZERO))

    def require(self, bounds: Iterable[Bound]) -> None:
        """Add clock constraints that hold now."""
        for clock, op, value in bounds:
            if op in ("<", "<=", "=="):
                self.require_difference(clock, 0, below(value) if op == "<" else at_most(value))
            if op in (">", ">=", "=="):
                self.require_difference(0, clock, below(-value) if op == ">" else at_most(-value))

    def require_difference(self, left: int, right: int, bound: int) -> None:
        """Add a bound on the present difference of two clocks; 0 is the clock that is always zero."""
        if bound == INFINITY:
            return
        since_left, value_left = self._set.get(left, (0, 0)) if left else (self.now, 0)
        since_right, value_right = self._set.get(right, (0, 0)) if right else (self.now, 0)
        # (now - since_left + value_left) - (now - since_right + value_right)
        self._bounds.append((since_right, since_left, bound + 2 * (value_right - value_left)))

    def set(self, clock: int, value: int) -> None:
        """Set a clock to a value now."""
        self._set[clock] = (self.now, value)

    def solve(self) -> list[Fraction]:
        """Return the earliest times of all instants, with denominators as small as possible.

        Raises:
            AssertionError: no times exist; the run is not one of the network.
        """
        for margin in (*_MARGINS, Fraction(1, self.now + 2)):
            times = self._earliest(margin)
            if times is not None:
                return times
        raise AssertionError("a symbolic run without times")

    def _earliest(self, margin: Fraction) -> list[Fraction] | None:
        bounds = [(a, b, (bound >> 1) - (0 if bound & 1 else margin)) for a, b, bound in self._bounds]
        times = [Fraction(0)] * (self.now + 1)
        for _ in range(self.now + 2):
            changed = False
            for a, b, most in bounds:
                if times[a] - times[b] > most:
                    times[b] = times[a] - most
                    changed = True
            if not changed:
                return times if times[0] == 0 else None
            if times[0] > 0:
                return None
        return None
