"""Executing some processes of a network: events and time go in, steps and a deadline come out.

Sans-IO: time is an argument, integer microseconds, and is never read. The order is documented and deterministic:
committed locations first; an event before a time-out that is due at the same instant; what is due earlier first;
then the order of the system line, of the edges in the file, of the receivers.

Lateness changes when an edge is taken, never which: an edge is a candidate if there is an instant, from the
entry into the present discrete state on, at which the model allows it, and it is due at the first such instant.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping

from timed_automata.document import fault
from timed_automata.errors import ModelError, RangeError, UsageError
from timed_automata.execute._boundary import boundary_of
from timed_automata.execute._clocks import NEVER, ClockInstants
from timed_automata.execute._observations import (
    Begun,
    Event,
    ExecutionSnapshot,
    Observation,
    Reaction,
    Received,
    Step,
    Written,
)
from timed_automata.execute._schedule import Schedule, ScheduledTransition
from timed_automata.execute._snapshots import resume, snapshot_of
from timed_automata.execute._successors import Successor, SuccessorCache
from timed_automata.network import Network, Semantics, State

_MOST_STEPS = 10_000  # at one instant: more is a livelock


class Execution:
    """The executed processes of a network in one state.

    Args:
        network: a loaded network.
        executed: names of processes or templates; everything else is the environment.
        interface: names of the variables that both sides share.
        unit_us: length of the model's unit of time.
        observe: called with each input and each step, in order.

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
        """Channels that :meth:`receive` takes."""
        self.outputs = frozenset(self._boundary.outputs)
        """Channels on which steps may have ``sent``."""
        self._state = network.initial
        self._now: int | None = None

    @property
    def state(self) -> State:
        """Locations and values; of the environment only the interface is meaningful."""
        return self._state

    @property
    def deadline(self) -> int | None:
        """The next time, µs, at which something is due; it may be now, or past if time came late."""
        return self._schedule.deadline

    def value(self, name: str) -> int:
        """The value of ``ee``, ``evidence[1]``, ``Gripper.i``; booleans are 0 and 1."""
        return self._state.values[self.network.offset(name)]

    def location(self, process: str) -> str:
        """The name of the location that a process is in."""
        chosen = self.network.process(process)
        return chosen.locations[self._state.locations[chosen.index]].name

    def start(self, at: int, inputs: Mapping[str, int] | None = None) -> tuple[Step, ...]:
        """Begin: clocks are zero at ``at``, interface variables get ``inputs``, committed steps are taken.

        Raises:
            UsageError: it is started already, or an input is not one.
        """
        if self._now is not None:
            raise UsageError("The execution is started already.")
        writes = self._boundary.writes(inputs or {})
        self._now = at
        self._clocks.start(at)
        self._observe(Begun(at, dict(inputs or {})))
        self._state = _with(self._state, writes)
        self._schedule.renew(self._state, at, None)
        return tuple(self._at_once(at))

    def receive(self, event: Event, at: int, *, stamp: int | None = None) -> Reaction:
        """Take what is due before ``at``, then the event, then what follows from it without delay.

        With ``stamp``, the earlier time at which the event happened: what is due before that, and not what became
        due while the event was on its way. All of it is taken at ``at``.

        What a clock makes due at ``at`` itself waits for :meth:`advance`: another event may have the same time.
        An ``at`` before the latest time of a call counts as that time. What the event writes is written even if
        no edge receives the event.

        Raises:
            UsageError: no such input, or a variable that is not interface or out of range.
            ModelError: the network came to where it cannot go on.
        """
        channel, writes = self._boundary.input(event.channel), self._boundary.writes(event.writes)
        now = self._advance_clock(at)
        steps = self._take(now, (now if stamp is None else min(stamp, now)) - 1)
        self._observe(Received(now, event.channel, event.writes))
        taken = self._receive(now, event.channel, channel, writes)
        return Reaction(taken is not None, (*steps, *([taken] if taken else []), *self._at_once(now)))

    def takes(self, event: Event) -> bool:
        """Whether an edge would receive an event now, before anything that is due; nothing is changed by asking.

        Raises:
            UsageError: no such input, or a variable that is not interface or out of range.
        """
        channel, writes = self._boundary.input(event.channel), self._boundary.writes(event.writes)
        return self._successors.received(self._state, channel, writes) is not None

    def write(self, writes: Mapping[str, int], at: int | None = None) -> tuple[Step, ...]:
        """Set interface variables without an event.

        With ``at`` as if an event came that no edge receives; without, nothing is taken until the next call
        with a time.
        """
        offsets = self._boundary.writes(writes)
        now = self._advance_clock(at)
        steps = () if at is None else self._take(now, now - 1)
        if self._write(now, offsets):
            self._observe(Written(now, writes))
        return () if at is None else (*steps, *self._at_once(now))

    def advance(self, at: int) -> tuple[Step, ...]:
        """Take what is due at or before ``at``, one after the other as its lateness allows, all at ``at``."""
        now = self._advance_clock(at)
        return tuple(self._take(now, now))

    def snapshot(self) -> ExecutionSnapshot | None:
        """Where it stands; None: it is not started."""
        if self._now is None:
            return None
        zeros, entered = self._clocks.zeros, self._schedule.entered
        return snapshot_of(self.network, self._state, zeros, at=self._now, entered=entered)

    def resume(self, snapshot: ExecutionSnapshot) -> None:
        """Stand where another execution of the same network stood.

        Raises:
            UsageError: the snapshot is not of this network, or contradicts itself.
        """
        resumed = resume(self.network, snapshot)
        self._state, self._now = resumed.state, snapshot.at
        self._clocks.resume(resumed.zeros)
        self._schedule.renew(resumed.state, snapshot.entered, None)

    def look_ahead(self, events: Iterable[Event]) -> Iterator[State]:
        """Work out what each of some events would lead to now, and what time would, and what follows at once.

        Nothing is taken, and nothing is decided otherwise: when one of them comes, what it does is remembered, not
        computed. Each item is one state; a caller with other work stops asking. It may be iterated in
        another thread than the one that executes.

        Raises:
            UsageError: no such input, or a variable that is not interface or out of range.
        """
        inputs = [
            (self._boundary.input(event.channel), self._boundary.writes(event.writes)) for event in events
        ]
        return self._successors.explore(self._state, inputs)

    def run(self, until: int) -> tuple[Step, ...]:
        """Advance in virtual time, from deadline to deadline, each of them met."""
        steps: list[Step] = []
        while (deadline := self.deadline) is not None and deadline <= until:
            steps += self.advance(deadline)
        return (*steps, *self.advance(until))

    # The machine

    def _advance_clock(self, at: int | None) -> int:
        """The latest time of all calls, this one included."""
        if self._now is None:
            raise UsageError("The execution is not started.", todo="Call start() first.")
        self._now = max(self._now, at) if at is not None else self._now
        return self._now

    def _at_once(self, now: int) -> list[Step]:
        """Take what does not wait for a clock: all but what reaches a lower bound at this very instant."""
        return self._take(now, now, first_before=now)

    def _write(self, now: int, offsets: Mapping[int, int]) -> bool:
        """Whether anything has changed."""
        values = self._state.values
        changes = any(values[offset] != value for offset, value in offsets.items())
        if changes:
            self._state = _with(self._state, offsets)
            self._schedule.renew(self._state, now, None)
        return changes

    def _receive(self, now: int, name: str, channel: int, writes: Mapping[int, int]) -> Step | None:
        successor = self._successors.received(self._state, channel, writes)
        if successor is None:
            self._write(now, writes)
            return None
        return self._move(now, successor, None, self._schedule.last, received=name)

    def _take(self, now: int, until: int, first_before: int = NEVER) -> list[Step]:
        """Take at ``now`` what is due at or before ``until``; see `Schedule.next`."""
        steps: list[Step] = []
        while candidate := self._schedule.next(until, first_before):
            if len(steps) == _MOST_STEPS:
                raise self._livelock(steps, candidate)
            steps.append(self._move(now, candidate.successor, candidate.due, candidate.last))
        if self._schedule.committed and not self._schedule.candidates:
            raise self._stuck()
        return steps

    def _move(
        self, now: int, successor: Successor, due: int | None, last: int, received: str | None = None
    ) -> Step:
        transition, fired = successor.transition, successor.fired
        if isinstance(fired, RangeError):
            raise fired
        self._state = fired.state
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
                return fault(location.drawn.place.whole, what, "Its guards leave out a case.")
        raise AssertionError("no committed location")  # pragma: no cover


def _with(state: State, offsets: Mapping[int, int]) -> State:
    values = list(state.values)
    for offset, value in offsets.items():
        values[offset] = value
    return State(state.locations, tuple(values))


def _unobserved(_: Observation) -> None:
    """Nobody looks."""


def _shared_successors(network: Network, executed: frozenset[int]) -> SuccessorCache:
    """Those of all who execute the same processes of a network: one who begins later finds what others worked out."""
    found: SuccessorCache | None = network.derived.get((SuccessorCache, executed))
    if found is None:
        found = network.derived[SuccessorCache, executed] = SuccessorCache(Semantics(network, executed))
    return found
