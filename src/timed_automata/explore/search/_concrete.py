"""From a symbolic run to a concrete one with absolute times."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from timed_automata.explore.search._delay import Grow, freely
from timed_automata.explore.search._timing import Timing
from timed_automata.explore.states import Move, StateRecord, SymbolicSpace
from timed_automata.explore.zones import Zone, constraints_of
from timed_automata.network import Trace, TraceStep, changes_between

Ending = Callable[[StateRecord, Zone], Zone | None]


class NoRunError(Exception):
    """The legs are not those of a run."""


class Leg(NamedTuple):
    """A part of a run: a move (None: none, from here on another rule holds for delays), then a delay."""

    move: Move | None
    grow: Grow = freely


class _Visit(NamedTuple):
    """A leg among exact zones: the record, where it is entered, what a delay makes of that."""

    record: StateRecord
    entry: Zone | None  # None: anywhere
    later: Zone | None


def concrete(
    space: SymbolicSpace, legs: Sequence[Leg], ending: Ending, remark: str, *, loop: int | None = None
) -> Trace:
    """The earliest run along the legs that then satisfies ``ending`` (the part of a zone that does).

    Args:
        space: in which the run was found.
        legs: the first one has no move and starts in the initial state.
        ending: of the last leg.
        remark: how it ends.
        loop: number of the move to which the run returns.

    Raises:
        NoRunError: there is none; never for legs that a search has found.

    A run that is found among widened zones exists as it is (what is added to a zone is simulated by what was in
    it), so the zones along it are computed once more, without widening.
    """
    exact = SymbolicSpace(space.discrete, space.limits, delays=False, widens=False)
    record, zone = exact.initial()
    visits = _follow(exact, record, zone, list(legs), ending)
    if visits is None:
        raise NoRunError
    timing, instants = Timing(), []
    for leg, visit in zip(legs, visits, strict=True):
        if leg.move is not None:
            timing.require(leg.move.guard)
            for clock, value in leg.move.resets.items():
                timing.set(clock, value)
            instants.append(timing.now)
        _require(timing, visit.record, visit.entry)
        timing.advance(delays=visit.record.discrete.delays)
        timing.require(visit.record.discrete.invariant)
        _require(timing, visit.record, visit.later)
    times = timing.solve()
    network, state, steps = space.discrete.network, record.discrete.state, []
    for move, instant in zip((leg.move for leg in legs if leg.move is not None), instants, strict=True):
        if move.target is None:
            break
        channel = None if move.channel is None else network.channels[move.channel].name
        after = move.target.state
        steps.append(
            TraceStep(times[instant], channel, move.edges, after, changes_between(network, state, after))
        )
        state = after
    return Trace(network, tuple(steps), times[-1], remark, loop)


def _require(timing: Timing, record: StateRecord, zone: Zone | None) -> None:
    if zone is not None:
        numbers = (0, *record.clocks)
        for i, j, bound in constraints_of(zone, record.n):
            timing.require_difference(numbers[i], numbers[j], bound)


def _follow(
    space: SymbolicSpace, record: StateRecord, zone: Zone, legs: list[Leg], ending: Ending
) -> list[_Visit] | None:
    """The exact zones of a run; where a condition leaves several ways to stay, the first that leads to the end."""
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
