"""Executes some processes of a network; its inputs are events and time, its outputs are steps and a deadline.

Sans-IO: time is an argument in integer microseconds and is never read from a clock. The order of steps is documented
and deterministic: committed locations first; an event before a time-out that is due at the same instant; an earlier
due time first; then the order of the system line, of the edges in the file, of the receivers.

A late call changes when an edge is taken, never which one: an edge is a candidate if the model allows it at some
instant after the entry into the present discrete state, and it is due at the first such instant.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from copy import copy
from typing import NamedTuple

from timed_automata.document import fault
from timed_automata.errors import ModelError, RangeError, UsageError
from timed_automata.execute._boundary import boundary_of
from timed_automata.execute._observations import (
    Begun,
    Event,
    ExecutionSnapshot,
    Observation,
    Reaction,
    Received,
    Step,
    Written,
    resume,
    snapshot_of,
)
from timed_automata.execute._schedule import Schedule, ScheduledTransition
from timed_automata.execute._successors import NEVER, ClockInstants, Successor, SuccessorCache
from timed_automata.network import Network, Semantics, State

_MOST_STEPS = 10_000  # at one instant: more is a livelock


class Foresight(NamedTuple):
    """The steps that an event would lead to now.

    Attributes:
        steps: the steps, as :meth:`Execution.receive` would return them; their times are those of the question.
        until: instant from which a clock may lead to other steps, µs.
        after: a copy of the execution, in the state after these steps.
    """

    steps: tuple[Step, ...]
    until: int
    after: Execution


class Execution:
    """The executed processes of a network and their current state.

    Args:
        network: a loaded network.
        executed: names of processes or templates; everything else is the environment.
        interface: names of the variables that both sides share.
        unit_us: length of the model's unit of time, µs.
        observe: called with every input and every step, in order.

    Raises:
        UsageError: a name is unknown.
        ModelError: the sides share more than the interface, or something cannot be executed.
    """

    def __init__(
        self,
        network: Network,
        executed: Iterable[str],
        interface: Iterable[str] = (),
        *,
        unit_us: int = 1000,
        observe: Callable[[Observation], None] | None = None,
    ) -> None:
        self.network = network
        self._observe = observe or _unobserved
        self._boundary = boundary_of(network, executed, interface)
        self._successors = _shared_successors(network, self._boundary.executed)
        self._clocks = ClockInstants(len(network.clocks), unit_us)
        self._schedule = Schedule(self._successors, self._clocks)
        self.inputs = frozenset(self._boundary.inputs)
        """Names of the channels that :meth:`receive` accepts."""
        self.outputs = frozenset(self._boundary.outputs)
        """Names of the channels that can be in ``sent`` of a step."""
        self._state = network.initial
        self._now: int | None = None

    @property
    def state(self) -> State:
        """Current locations and values; for the environment only the interface variables are meaningful."""
        return self._state

    @property
    def deadline(self) -> int | None:
        """Next time at which a transition is due, µs; it may be now, or in the past if the last call was late."""
        return self._schedule.deadline

    def deadline_without(self, processes: frozenset[int]) -> int | None:
        """Return the time of the next time-out, µs, of a transition that does not begin in one of these processes."""
        found = self._successors.at(self._state).successors
        timed = (each for each in found if each.bounds and each.transition.edges[0].process not in processes)
        return min([self._clocks.window(each.bounds)[0] for each in timed], default=None)

    def value(self, name: str) -> int:
        """Return the value of a variable such as ``ee``, ``evidence[1]`` or ``Gripper.i``; booleans are 0 and 1."""
        return self._state.values[self.network.offset(name)]

    def location(self, process: str) -> str:
        """Return the name of the current location of a process."""
        chosen = self.network.process(process)
        return chosen.locations[self._state.locations[chosen.index]].name

    def start(self, at: int, inputs: Mapping[str, int] | None = None) -> tuple[Step, ...]:
        """Start with all clocks at zero at ``at``, set interface variables to ``inputs``, and take committed steps.

        Raises:
            UsageError: the execution is started already, or a name in ``inputs`` is not an input.
        """
        if self._now is not None:
            raise UsageError("The execution is started already.")
        writes = self._boundary.writes(inputs or {})
        self._now = at
        self._clocks.start(at)
        self._observe(Begun(at, dict(inputs or {})))
        self._state = _with(self._state, writes)
        self._schedule.renew(self._state, at, None)
        return tuple(self._take(at, at, first_before=at))

    def receive(self, event: Event, at: int, *, stamp: int | None = None) -> Reaction:
        """Take the transitions that are due before ``at``, then the event, then the steps that follow without delay.

        ``stamp`` is the earlier time at which the event happened: then only transitions due before ``stamp`` precede
        the event, not those that became due while the event was on its way. All steps are taken at ``at``. A
        transition that a clock makes due exactly at ``at`` waits for :meth:`advance`, because another event may have
        the same time.

        An ``at`` earlier than that of a previous call counts as the latest time so far. The variables of the event are
        written even if no edge receives the event.

        Raises:
            UsageError: no such input, or a variable that is not in the interface or out of range.
            ModelError: the network reached a state from which it cannot continue.
        """
        channel, writes = self._boundary.input(event.channel), self._boundary.writes(event.writes)
        now = self._advance_clock(at)
        steps = self._take(now, (now if stamp is None else min(stamp, now)) - 1)
        self._observe(Received(now, event.channel, event.writes))
        successor = self._successors.received(self._state, channel, writes)
        if successor is None:
            self._write(now, writes)
        else:
            steps.append(self._move(now, successor, None, self._schedule.last, received=event.channel))
        steps += self._take(now, now, first_before=now)
        return Reaction(successor is not None, tuple(steps))

    def takes(self, event: Event) -> bool:
        """Return whether an edge would receive an event now, before any due transition; the state is not changed.

        Raises:
            UsageError: no such input, or a variable that is not in the interface or out of range.
        """
        channel, writes = self._boundary.input(event.channel), self._boundary.writes(event.writes)
        return self._successors.received(self._state, channel, writes) is not None

    def write(self, writes: Mapping[str, int], at: int | None = None) -> tuple[Step, ...]:
        """Set interface variables without an event.

        With ``at``, the call acts like an event that no edge receives; without it, no transition is taken until the
        next call that has a time.
        """
        offsets = self._boundary.writes(writes)
        now = self._advance_clock(at)
        steps = [] if at is None else self._take(now, now - 1)
        if self._write(now, offsets):
            self._observe(Written(now, writes))
        return () if at is None else (*steps, *self._take(now, now, first_before=now))

    def advance(self, at: int) -> tuple[Step, ...]:
        """Take all transitions that are due at or before ``at``, in order of their due times; all are taken
        at ``at``.
        """
        now = self._advance_clock(at)
        return tuple(self._take(now, now))

    def snapshot(self) -> ExecutionSnapshot | None:
        """Return the current state as a snapshot, or None before the start."""
        if self._now is None:
            return None
        zeros, entered = self._clocks.zeros, self._schedule.entered
        return snapshot_of(self.network, self._state, zeros, at=self._now, entered=entered)

    def resume(self, snapshot: ExecutionSnapshot) -> None:
        """Continue from the snapshot of another execution of the same network.

        Raises:
            UsageError: the snapshot belongs to another network, or contradicts itself.
        """
        resumed = resume(self.network, snapshot)
        self._state, self._now = resumed.state, snapshot.at
        self._clocks.resume(resumed.zeros)
        self._schedule.renew(resumed.state, snapshot.entered, None)

    def foresee(self, event: Event | None) -> Foresight | None:
        """Return what an event would lead to, if it came before anything else; the state does not change.

        The result is kept: it is not computed again when the event comes. Without an event the next time-out is
        computed. None is returned if no edge would receive the event, if something is due now, or if the model does not
        allow what follows.

        Raises:
            UsageError: no such input, or a variable that is not in the interface or out of range.
        """
        # one microsecond later, so that no clock but those of this reaction is zero now
        now, due = self._advance_clock(None) + 1, self.deadline
        if due is None if event is None else (due is not None and due <= now):
            return None
        ahead = copy(self)
        ahead._clocks = clocks = self._clocks.copy()
        ahead._schedule = self._schedule.copy(clocks)
        instants = [NEVER if due is None else due]

        def passed(_: Observation) -> None:
            instants.extend(clocks.instants(self._successors.at(ahead.state).bounds, now))

        ahead._observe = passed
        try:
            if event is None:
                steps = ahead.advance(due or now)
            elif not self.takes(event):
                return None
            else:
                steps = ahead.receive(event, now).steps
        except ModelError:  # it is a fault only if it comes to that
            return None
        return Foresight(steps, min(instants), ahead)

    def run(self, until: int) -> tuple[Step, ...]:
        """Advance in virtual time from deadline to deadline, without lateness."""
        steps: list[Step] = []
        while (deadline := self.deadline) is not None and deadline <= until:
            steps += self.advance(deadline)
        return (*steps, *self.advance(until))

    # The machine

    def _advance_clock(self, at: int | None) -> int:
        """Set the time to the latest of all calls, including this one, and return it."""
        if self._now is None:
            raise UsageError("The execution is not started.", todo="Call start() first.")
        self._now = max(self._now, at) if at is not None else self._now
        return self._now

    def _write(self, now: int, offsets: Mapping[int, int]) -> bool:
        """Write variables; return whether a value changed."""
        values = self._state.values
        changes = any(values[offset] != value for offset, value in offsets.items())
        if changes:
            self._state = _with(self._state, offsets)
            self._schedule.renew(self._state, now, None)
        return changes

    def _take(self, now: int, until: int, first_before: int = NEVER) -> list[Step]:
        """Take at ``now`` all transitions that are due at or before ``until``; see `Schedule.next`.

        With ``first_before`` equal to ``now``, those whose lower bound a clock reaches exactly now are not taken.
        """
        steps: list[Step] = []
        schedule = self._schedule
        while (
            schedule.deadline is not None
            and schedule.deadline <= until
            and (candidate := schedule.next(until, first_before))
        ):
            if len(steps) == _MOST_STEPS:
                raise self._livelock(steps, candidate)
            steps.append(self._move(now, candidate.successor, candidate.due, candidate.last))
        if schedule.committed and not schedule.candidates:
            raise self._stuck()
        return steps

    def _move(
        self, now: int, successor: Successor, due: int | None, last: int, received: str | None = None
    ) -> Step:
        transition, fired = successor.transition, successor.fired
        if isinstance(fired, RangeError):
            raise fired
        self._state = fired.state
        if fired.resets:
            self._clocks.set(fired.resets, now)
        self._schedule.renew(self._state, now, transition)
        step = Step(
            at=now,
            due=due,
            late_us=now - due if due is not None else 0,
            missed=now > last,
            received=received,
            sent=successor.sent if received is None else None,
            edges=successor.edges,
            changes=successor.changes,
        )
        self._observe(step)
        return step

    def _livelock(self, steps: list[Step], candidate: ScheduledTransition) -> ModelError:
        names = sorted({edge.process for step in steps[-100:] for edge in step.edges})
        what = f"No end after {_MOST_STEPS} steps at one instant: {', '.join(names)} never rest."
        return fault(
            candidate.successor.transition.edges[0].span, what, "Add a guard, or let time pass on the way."
        )

    def _stuck(self) -> ModelError:
        for process in self.network.processes:
            location = process.locations[self._state.locations[process.index]]
            if process.index in self._boundary.executed and location.committed:
                what = f"No edge leads on from the committed location '{location.name}' of {process.name}."
                return fault(location.drawn.place.whole, what, "Its guards do not cover all cases.")
        raise AssertionError("no committed location")  # pragma: no cover


def _with(state: State, offsets: Mapping[int, int]) -> State:
    values = list(state.values)
    for offset, value in offsets.items():
        values[offset] = value
    return State(state.locations, tuple(values))


def _unobserved(_: Observation) -> None:
    """Ignore an observation; used if there is no observer."""


def _shared_successors(network: Network, executed: frozenset[int]) -> SuccessorCache:
    """Return the cache that all executions of the same processes share, so that a later one reuses its results."""
    found: SuccessorCache | None = network.derived.get((SuccessorCache, executed))
    if found is None:
        found = network.derived[SuccessorCache, executed] = SuccessorCache(Semantics(network, executed))
    return found
