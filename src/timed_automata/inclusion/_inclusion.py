"""Timed trace inclusion: checks that an implementation does at every time only what a specification allows.

Rule 1. A trace holds the inputs, the outputs on observed channels and the changes of observed variables, with their
times and in their order; a pause is a part of it.

Rule 2. The environment belongs to the specification. The implementation receives its events at the same instant.

Rule 3. All choices of the implementation are searched. The specification is deterministic: one trace leads to one
state of it. So inclusion depends only on the pairs of states that are reached, and no choice is lost.

Rule 4. The implementation is not included if, in a pair that is reached, it does something that the specification
cannot do, refuses an input that the specification accepts, or lets time pass where the specification must act.

Rule 5. An implementation that stops time does nothing more, and is included. `Explorer.timelock` detects that.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from timed_automata.compiler import Bound
from timed_automata.document import fault
from timed_automata.errors import UsageError
from timed_automata.explore.search import without_collector
from timed_automata.explore.zones import Zone, included
from timed_automata.inclusion._interface import Interface, inputs, sides
from timed_automata.inclusion._macro_steps import MacroStep, MacroSteps
from timed_automata.inclusion._run import CommonZones, ComparedNode, ComparedStep, run_to
from timed_automata.network import Network, State


@dataclass(frozen=True, slots=True)
class Inclusion:
    """The result of a comparison: whether an implementation does only what a specification allows.

    Attributes:
        holds: whether it does.
        states: number of pairs of states, each with a zone, that were stored.
        run: one of the shortest runs of both to the point where they differ; empty if they do not.
        end: time at which they differ.
        difference: the difference, in words; empty if there is none.
    """

    holds: bool
    states: int
    run: tuple[ComparedStep, ...] = ()
    end: Fraction = Fraction(0)
    difference: str = ""

    @property
    def lines(self) -> tuple[str, ...]:
        """The run as text, with the difference as its last line."""
        if self.holds:
            return ()
        return (*map(str, self.run), str(ComparedStep(self.end, self.difference)))


def trace_inclusion(implementation: Network, specification: Network, interface: Interface) -> Inclusion:
    """Decide whether every timed trace of the implementation is one of the specification.

    Raises:
        UsageError: a network lacks a name of the interface, or they start differently.
        ModelError: the specification is not deterministic, or a network uses an unsupported construct; with its place.
        RangeError: a value leaves its range in a run.
    """
    with without_collector():
        return _Product(implementation, specification, interface).explore()


class _PartingError(Exception):
    """The networks differ here, in some part of a zone."""

    def __init__(self, node: ComparedNode, zone: Zone, what: str) -> None:
        self.node, self.zone, self.what = node, zone, what


class _Product:
    def __init__(self, implementation: Network, specification: Network, interface: Interface) -> None:
        both = sides(implementation, specification, interface)
        self._ours, self._theirs = map(MacroSteps, both)
        self._inputs = inputs(*both)
        self._zones = CommonZones(both)
        self._environment = both[1].environment
        self._channels = {channel.name: number for number, channel in enumerate(implementation.channels)}
        self._pairs: dict[tuple[State, State], list[Zone]] = {}
        self._waiting: deque[ComparedNode] = deque()
        self._states = 0
        self._interface = interface

    def explore(self) -> Inclusion:
        try:
            self._begin()
            while self._waiting:
                node = self._waiting.popleft()
                self._inputs_of(node)
                self._outputs_of(node)
        except _PartingError as parting:
            run, end = run_to(parting.node, parting.zone, self._zones, self._invariant)
            return Inclusion(False, self._states, run, end, parting.what)
        return Inclusion(True, self._states)

    # The start

    def _begin(self) -> None:
        network, side = self._theirs.side.network, self._theirs.side
        theirs = network.initial
        if self._theirs.semantics.committed(theirs):
            raise UsageError("The specification starts in a committed location: it must start at rest.")
        ours = self._start(theirs)
        for (name, at), (_, here) in zip(side.observed, self._ours.side.observed, strict=True):
            if theirs.values[at] != ours.values[here]:
                what = f"'{name}' starts as {ours.values[here]} in the implementation and as {theirs.values[at]} in "
                raise UsageError(f"{what}the specification.")
        for bounds, whose in (
            (self._ours.invariant(ours), "implementation"),
            (self._theirs.invariant(theirs), "specification"),
        ):
            if self._zones.within(self._zones.start, bounds) is None:
                raise UsageError(f"An invariant of the {whose} does not hold at its start.")
        self._meet(None, ours, theirs, self._zones.start, "")

    def _start(self, theirs: State) -> State:
        network, semantics = self._ours.side.network, self._ours.semantics
        values = list(network.initial.values)
        for at, here in self._inputs:
            values[here] = theirs.values[at]
        for name, value in self._interface.start.items():
            values[network.offset(name)] = value
        state = State(network.initial.locations, tuple(values))
        for name in self._interface.before:
            found = self._ours.to(state, self._channel(name), {})
            if len(found) != 1 or found[0].bounds:
                raise UsageError(
                    f"At its start the implementation answers '{name}' in {len(found)} ways, not in one."
                )
            state = found[0].state
        if semantics.committed(state):
            raise UsageError("The implementation starts in a committed location: it must start at rest.")
        return state

    def _channel(self, name: str) -> int:
        if name not in self._channels:
            raise UsageError(f"The implementation has no channel '{name}': it cannot receive this input.")
        return self._channels[name]

    # Steps

    def _meet(
        self,
        parent: ComparedNode | None,
        ours: State,
        theirs: State,
        zone: Zone,
        what: str,
        *steps: MacroStep,
    ) -> None:
        """Enter a pair of states, and let time pass as the implementation and the environment allow."""
        grown = self._zones.within(self._zones.later(zone), self._invariant(ours, theirs))
        if grown is None:
            return
        node = ComparedNode(parent, ours, theirs, grown, what, steps)
        required = self._theirs.invariant(theirs, environment=False)
        if too_late := self._zones.without([grown], required):
            what = "the implementation lets time pass; the specification must do something before."
            raise _PartingError(node, too_late[0], what)
        wide = self._zones.widened(grown, (ours, theirs))
        passed = self._pairs.setdefault((ours, theirs), [])
        if any(included(wide, known) for known in passed):
            return
        passed[:] = [known for known in passed if not included(known, wide)]
        passed.append(wide)
        self._states += 1
        self._waiting.append(ComparedNode(parent, ours, theirs, wide, what, steps))

    def _invariant(self, ours: State, theirs: State) -> tuple[Bound, ...]:
        return (*self._ours.invariant(ours), *self._theirs.invariant(theirs, environment=True))

    def _step(
        self, node: ComparedNode, zone: Zone, what: str, ours: MacroStep | None, theirs: MacroStep | None
    ) -> None:
        steps = [each for each in (ours, theirs) if each is not None]
        part: Zone | None = zone
        for each in steps:
            part = self._zones.within(part, each.bounds) if part is not None else None
        if part is None:
            return
        resets = {place: value for each in steps for place, value in each.resets.items()}
        self._meet(
            node,
            ours.state if ours else node.ours,
            theirs.state if theirs else node.theirs,
            self._zones.set(part, resets),
            what,
            *steps,
        )

    def _outputs_of(self, node: ComparedNode) -> None:
        """Follow the implementation's own steps: the specification must do the same."""
        every = [each for each in self._theirs.of(node.theirs) if not self._is_input(each)]
        for each in every:
            if not each.seen and self._zones.within(node.zone, each.bounds) is not None:
                what = f"The step '{self._place(each)}' has no observed effect: the specification is not deterministic."
                raise fault(each.edges[0].span, what, "Observe something that it changes.")
        self._require_one(node, every)
        for ours in self._ours.of(node.ours):
            part = self._zones.within(node.zone, ours.bounds)
            if part is None:
                continue
            if not ours.seen:
                self._step(node, part, "", ours, None)
                continue
            matching = [each for each in every if each.seen == ours.seen]
            left = [part]
            for each in matching:
                left = self._zones.without(left, each.bounds)
            what = "; ".join(ours.seen)
            if left:
                raise _PartingError(
                    node, left[0], f"the implementation does what the specification cannot: {what}."
                )
            for each in matching:
                self._no_input_written(each, node.theirs)
                self._step(node, part, what, ours, each)

    def _inputs_of(self, node: ComparedNode) -> None:
        """Follow the steps of the environment: both networks must accept them and react in the same way."""
        groups: dict[object, list[MacroStep]] = defaultdict(list)
        for each in self._theirs.of(node.theirs):
            if self._is_input(each):
                groups[tuple(edge for edge in each.edges if edge.process in self._environment)].append(each)
        for group in groups.values():
            self._require_one(node, group)
            self._input(node, group)

    def _input(self, node: ComparedNode, group: Sequence[MacroStep]) -> None:
        name, channel = self._name(group[0]), None
        if name and (name in self._channels or self._heard(group)):
            channel = self._channel(name)
        writes = {here: group[0].first.values[at] for at, here in self._inputs}
        answers = self._ours.to(node.ours, channel, writes)
        for theirs in group:
            self._no_input_written(theirs, theirs.first)
            part = self._zones.within(node.zone, theirs.bounds)
            if part is None:
                continue
            left = [part]
            for ours in answers:
                left = self._zones.without(left, ours.bounds)
            if left:
                raise _PartingError(node, left[0], f"the implementation refuses the input {name}.")
            for ours in answers:
                self._answer(node, part, name, ours, theirs, group)

    def _answer(
        self,
        node: ComparedNode,
        part: Zone,
        name: str,
        ours: MacroStep,
        theirs: MacroStep,
        group: Sequence[MacroStep],
    ) -> None:
        both = self._zones.within(part, ours.bounds)
        if both is None:
            return
        left = [both]
        for each in group:
            if each.seen == ours.seen:
                left = self._zones.without(left, each.bounds)
        told = f"input {name}" if name else "the environment changes"
        if left:
            does, may = ("; ".join(each.seen) or "nothing is seen" for each in (ours, theirs))
            what = f"{told}: {does} in the implementation; {may} in the specification."
            raise _PartingError(node, left[0], what)
        if theirs.seen == ours.seen:
            self._step(
                node, both, ": ".join([told, "; ".join(ours.seen)]) if ours.seen else told, ours, theirs
            )

    # The specification

    def _is_input(self, step: MacroStep) -> bool:
        return step.edges[0].process in self._environment

    def _heard(self, group: Sequence[MacroStep]) -> bool:
        """Return whether a process other than the environment receives the input in the specification."""
        return any(edge.process not in self._environment for each in group for edge in each.edges)

    def _name(self, step: MacroStep) -> str:
        return "" if step.channel is None else self._theirs.side.network.channels[step.channel].name

    def _require_one(self, node: ComparedNode, steps: Sequence[MacroStep]) -> None:
        """Check that one trace leads to one state of the specification.

        Raises:
            ModelError: two macro-steps have the same observations, and lead to different states.
        """
        for number, one in enumerate(steps):
            for other in steps[:number]:
                if one.seen != other.seen or not self._differ(one, other):
                    continue
                both = self._zones.within(node.zone, (*one.bounds, *other.bounds))
                if both is not None:
                    first, second = self._place(other), self._place(one)
                    what = f"The specification is not deterministic: '{first}' and '{second}' look the same"
                    raise fault(
                        one.edges[0].span, f"{what}, and lead to different states.", "Observe more of them."
                    )

    def _differ(self, one: MacroStep, other: MacroStep) -> bool:
        """Return whether two macro-steps lead to different states without a different choice of the environment."""
        if [e for e in one.edges if e.process in self._environment] != [
            e for e in other.edges if e.process in self._environment
        ]:
            return False
        return (one.state, dict(one.resets)) != (other.state, dict(other.resets))

    def _no_input_written(self, step: MacroStep, before: State) -> None:
        """Refuse an environment that changes an input together with an output: the implementation would read it too
        late.

        Raises:
            ModelError: the environment changes an input within a macro-step.
        """
        if any(before.values[at] != step.state.values[at] for at, _ in self._inputs):
            what = "The environment changes what the implementation reads at the instant of an output."
            edge = next(e for e in reversed(step.edges) if e.process in self._environment)
            raise fault(edge.span, what, "Let it change by an edge of its own.")

    def _place(self, step: MacroStep) -> str:
        edge = step.edges[0]
        process = self._theirs.side.network.processes[edge.process]
        source, target = (process.locations[at].name for at in (edge.source, edge.target))
        return f"{process.name}: {source} -> {target}"
