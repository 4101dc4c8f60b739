"""Follows a recorded run: every step must be one that the network allows at that time.

It shares the rules of the network (`Semantics`) with the executor, and nothing else: due times, order and lateness are
computed here once more, from the values of the clocks.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

from timed_automata.errors import RangeError, UsageError
from timed_automata.execute import (
    Begun,
    ExecutionBoundary,
    ExecutionSnapshot,
    Observation,
    Received,
    Step,
    Written,
    resume,
)
from timed_automata.monitor._concrete_state import (
    ConcreteState,
    changes_in_words,
    in_words,
    named,
    recorded_in,
    same_edges,
    shortened,
    why_not,
)
from timed_automata.monitor._monitored_query import monitored_queries
from timed_automata.network import Network, State, Transition, changes_between

_LONGEST_US = 2**63
"""Largest plausible lateness, µs; no clock shows more."""
ObjectionKind = Literal["no run", "missed", "requirement"]


@dataclass(frozen=True, slots=True)
class Objection:
    """One finding about a run.

    Attributes:
        at: time of the finding, in the time of the run.
        kind: ``no run``: the network does not allow it; ``missed``: a reaction bound was exceeded, as recorded;
            ``requirement``: a query ``A[]`` of the file did not hold.
        what: the finding, in words.
    """

    at: int
    kind: ObjectionKind
    what: str


class Monitor:
    """Judges a run, observation by observation.

    The edges that a step names are not trusted: its effect must be that of a transition that the network has then. If
    exactly one transition has this effect, the monitor follows that one. After a step that the network does not have,
    nothing more is judged: the state is unknown.

    Args:
        network: a loaded network, with the constants that were executed.
        executed: names of processes or templates; everything else is the environment. None: all of them.
        interface: names of the variables that both sides share.
        unit_us: length of the model's unit of time, in units of the run's time.
        requirements: judge also the queries of the file, as far as they can be judged.

    Attributes:
        objections: the findings against the run, in order.
        steps: number of steps that were judged.
        queries: the queries of the file that are judged.
    """

    def __init__(
        self,
        network: Network,
        executed: Iterable[str] | None = None,
        interface: Iterable[str] = (),
        *,
        unit_us: int = 1000,
        requirements: bool = False,
    ) -> None:
        self.network = network
        self._boundary = ExecutionBoundary(network, executed, interface) if executed is not None else None
        ours = self._boundary.executed if self._boundary else frozenset(range(len(network.processes)))
        self.queries = monitored_queries(network, ours) if requirements else ()
        self.objections: list[Objection] = []
        self.steps = 0
        self._concrete = ConcreteState(network, ours, unit_us)
        self._broken: set[int] = set()
        self._now = 0
        self._event: Received | None = None
        self._begun = self._following = False

    @property
    def state(self) -> State:
        """Locations and values after the last observation."""
        return self._concrete.state

    def begin(self, at: int, writes: Mapping[str, int] | None = None) -> None:
        """Start a run with all clocks at zero and these values of the interface."""
        self._begun = self._following = True
        self._event, self._broken = None, set()
        self._now = at
        self._concrete.begin(at)
        self._concrete.write(writes or {}, at)
        if not self._concrete.stays(at):
            self._refuse(at, "An invariant does not hold in the initial state.")
        self._judge()

    def resume(self, snapshot: ExecutionSnapshot) -> None:
        """Start in the middle of a run, in the recorded state."""
        self._begun, self._event, self._broken = True, None, set()
        self._now = snapshot.at
        try:
            self._concrete.resume(resume(self.network, snapshot), snapshot.entered)
        except UsageError as error:
            self._refuse(snapshot.at, str(error))
            return
        self._following = True
        if not self._concrete.may_delay() and snapshot.at > snapshot.entered:
            self._refuse(
                snapshot.at, "The recorded state is a committed or urgent location that was not left."
            )
        self._judge()

    @property
    def snapshot(self) -> ExecutionSnapshot | None:
        """The state of the run after the last observation; None if the monitor could not follow the run."""
        return self._concrete.snapshot(self._now) if self._following else None

    def observe(self, observation: Observation) -> None:
        """Judge the next observation."""
        if not self._begun and not isinstance(observation, Begun):
            self._begun = True
            self._refuse(observation.at, "The beginning is missing.")
        try:
            if isinstance(observation, Begun):
                self.begin(observation.at, observation.writes)
            elif isinstance(observation, Step) and observation.received is not None:
                self._take_event(observation)
            else:
                self._forget_event()
                self._next(observation)
        except (RangeError, UsageError) as error:
            self._refuse(observation.at, str(error))

    def end(self, at: int) -> None:
        """Judge the end of the run: nothing else happened until ``at``."""
        self._forget_event()
        if self._pass(at):
            self._judge()
            if not self._concrete.may_delay():
                self._refuse(at, "A committed or urgent location was not left.")
            elif not self._concrete.stays(at):
                self._refuse(at, "A deadline has passed, and no edge was taken.")

    # One observation

    def _next(self, observation: Written | Received | Step) -> None:
        if not self._pass(observation.at):
            return
        if isinstance(observation, Step):
            self._take(observation)
        elif isinstance(observation, Written):
            self._concrete.write(observation.writes, self._now)
            self._judge()
        else:
            self._event = observation

    def _pass(self, at: int) -> bool:
        """Let time pass; return whether the run is still followed."""
        if self._following and at < self._now:
            self._refuse(at, f"Time runs backwards, by {self._now - at} µs.")
        elif self._following and at > self._concrete.entered and not self._concrete.may_delay():
            self._refuse(at, "Time passed in a committed or urgent location.")
        self._now = max(at, self._now)
        return self._following

    def _forget_event(self) -> None:
        """Judge an event that no edge received: no edge must have been able to receive it."""
        event, self._event = self._event, None
        if event is None or not self._following:
            return
        if transition := self._reception(event):
            who = in_words(self.network, transition.edges)
            self._refuse(event.at, f"'{event.channel}' was lost, but could have been received: {who}.")
            return
        self._concrete.write(event.writes, self._now)
        self._judge()

    def _reception(self, event: Received) -> Transition | None:
        return self._concrete.reception(self._boundary.input(event.channel)) if self._boundary else None

    def _take_event(self, step: Step) -> None:
        event, self._event = self._event, None
        if not self._following:
            return
        if event is None or (event.channel, event.at) != (step.received, step.at):
            self._refuse(step.at, f"{named(step)} received '{step.received}', which was not sent then.")
        elif (transition := self._reception(event)) is None:
            self._refuse(step.at, f"No process can receive '{event.channel}' then, but {named(step)} did.")
        else:
            if not same_edges(self.network, transition, step):
                who = in_words(self.network, transition.edges)
                what = f"'{event.channel}' is recorded as received by {named(step)}, but {who} received it."
                self._object(step.at, "no run", what)
            if step.due is not None or step.late_us != 0:
                self._object(step.at, "no run", f"{named(step)} received an event, and is recorded as due.")
            # when an event comes is not the machine's doing: only the invariants are asked
            self._judge_lateness(step, in_time=self._concrete.stays(step.at))
            self._fire(transition, step, event)

    def _take(self, step: Step) -> None:
        concrete = self._concrete
        recorded = recorded_in(concrete, step)
        found = self._explanation(step, recorded) or recorded
        if recorded is None:
            why = why_not(self.network, concrete.state, step)
            self._object(step.at, "no run", f"{named(step)} was taken but not enabled: {why}.")
        elif found is not None and found.edges != recorded.edges:
            who = in_words(self.network, found.edges)
            what = f"{named(step)} is recorded, but {who} comes first, and has the recorded effect."
            self._object(step.at, "no run", what)
        if found is None:
            self._following = False
        elif not concrete.enabled(found, step.at):
            self._refuse(step.at, f"{named(step)} was taken before its time.")
        else:
            if self._boundary is not None or step.due is not None:
                self._judge_order(step, found)
            self._judge_lateness(step, in_time=concrete.in_time(found, step.at))
            self._fire(found, step)

    def _explanation(self, step: Step, recorded: Transition | None) -> Transition | None:
        """Return a transition with the same effect as a step, independent of the edges that the step names.

        For an execution the recorded one is preferred if it comes first, then one that comes first; otherwise the
        recorded one; else the only one.
        """
        doing = [t for t in self._concrete.transitions() if self._does(t, step)]
        known = self._first(step.at) if self._boundary is not None else []
        if recorded is not None:
            told = [each for each in known if each.edges == recorded.edges]
            known = [*told, *known, recorded]
        for each in known:
            if any(each.edges == other.edges for other in doing):
                return each
        return doing[0] if len(doing) == 1 else None

    def _first(self, at: int) -> list[Transition]:
        """Return the transitions that may come first: the one that is due first; of several, the first in the file.

        An execution takes a transition that reaches a lower bound at this very instant after all events of the
        instant; before that, it may take one that waits for no clock. So there may be two.
        """
        timed = self._concrete.timed
        waiting = (each for each in timed if each.reached < at and each.due <= at)
        firsts = (
            min(timed, key=lambda each: each.due, default=None),
            min(waiting, key=lambda each: each.due, default=None),
        )
        return [each.transition for each in firsts if each is not None]

    def _does(self, transition: Transition, step: Step) -> bool:
        try:
            fired = self._concrete.fire(transition.edges)
        except RangeError:
            return False
        does = changes_between(self.network, self._concrete.state, fired.state), self._sent(transition)
        return does == (tuple(step.changes), step.sent) and self._concrete.enabled(transition, step.at)

    def _sent(self, transition: Transition) -> str | None:
        return None if transition.channel is None else self.network.channels[transition.channel].name

    # What is asked of a step

    def _judge_lateness(self, step: Step, *, in_time: bool) -> None:
        """Object to a step that came too late, and to a record with the wrong lateness."""
        if not in_time and not step.missed:
            self._object(
                step.at, "no run", f"{named(step)} came after its time, and is not recorded as late."
            )
        elif in_time and step.missed:
            self._object(step.at, "no run", f"{named(step)} is recorded as late, but was in time.")
        elif step.missed:
            known = step.due is not None and abs(step.late_us) < _LONGEST_US
            behind = f"{step.late_us / 1000:.3f} ms late" if known else "too late"
            self._object(step.at, "missed", f"{named(step)} was taken {behind}: beyond its bound.")

    def _judge_order(self, step: Step, taken: Transition) -> None:
        """Object to a step that is not due first; of those due at once, the first in the file comes first."""
        timed = self._concrete.timed
        due = next((each.due for each in timed if each.transition.edges == taken.edges), None)
        if due != step.due or step.late_us != step.at - (step.due or 0):
            recorded = f"{shortened(step.due)} µs, {shortened(step.late_us)} µs before it was taken"
            what = f"{named(step)} was due at {due} µs; recorded is {recorded}."
            self._object(step.at, "no run", what)
        firsts = self._first(step.at)
        if firsts and due is not None and all(first.edges != taken.edges for first in firsts):
            who = in_words(self.network, firsts[0].edges)
            self._object(step.at, "no run", f"{named(step)} was taken before {who}, which comes first.")

    def _fire(self, transition: Transition, step: Step, event: Received | None = None) -> None:
        fired = self._concrete.fire(transition.edges, event.writes if event else None)
        changes = changes_between(self.network, self._concrete.state, fired.state)
        sent = self._sent(transition) if event is None else None
        if changes != tuple(step.changes):
            recorded = changes_in_words(step.changes)
            self._refuse(
                step.at, f"{named(step)} changes {changes_in_words(changes)}; recorded is {recorded}."
            )
        elif sent != step.sent:
            self._refuse(step.at, f"{named(step)} sends {sent}; recorded is {step.sent}.")
        else:
            self.steps += 1
            self._judge()  # of the state that is left
            self._concrete.move(transition, fired, step.at)
            if not step.missed and not self._concrete.stays(step.at):
                self._refuse(step.at, f"{named(step)} leads to where an invariant does not hold.")
            self._judge()

    def _judge(self) -> None:
        """Judge the queries of the file now; a violated query is reported once until it holds again."""
        for number, query in enumerate(self.queries):
            cases = query.violations(self._concrete.state)
            broken = any(self._concrete.holds(case.bounds, self._now) for case in cases)
            if broken and number not in self._broken:
                self._object(self._now, "requirement", f"Did not hold: {query.comment or query.text}")
            (self._broken.add if broken else self._broken.discard)(number)

    def _refuse(self, at: int, what: str) -> None:
        self._object(at, "no run", what)
        self._following = False

    def _object(self, at: int, kind: ObjectionKind, what: str) -> None:
        self.objections.append(Objection(at, kind, what))
