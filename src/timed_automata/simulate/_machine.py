"""A network in one concrete state: finds the possible transitions with their times, and takes one."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from timed_automata.errors import ModelError, RangeError
from timed_automata.execute import NEVER, ClockInstants, SuccessorCache
from timed_automata.network import Fired, Network, Semantics, TraceStep, Transition, changes_between

US_PER_UNIT = 1000  # the model's unit is the millisecond


class Option(NamedTuple):
    """A transition that is possible at every instant from ``first`` to ``last``, µs since the start.

    ``last`` is None if there is no limit. ``fired`` is its result, or the error that prevents it.
    """

    transition: Transition
    first: int
    last: int | None
    fired: Fired | RangeError


class Machine:
    """A network at an instant; all clocks are zero at 0 µs. Instants are whole microseconds.

    Raises:
        ModelError: the initial state violates an invariant.
    """

    def __init__(self, network: Network) -> None:
        self.network = network
        self.state = network.initial
        self.now = 0
        self._semantics = Semantics(network)
        self._successors = SuccessorCache(self._semantics)
        self._clocks = ClockInstants(len(network.clocks), US_PER_UNIT)
        self._clocks.start(0)
        first, last = self._clocks.window(self._semantics.invariant(self.state))
        if not self._semantics.allowed(self.state) or first > 0 or last < 0:
            what = "The initial state violates an invariant."
            raise ModelError(what, where=network.document.path, todo="No run begins there.")

    def _latest(self) -> int:
        return self._clocks.window(self._semantics.invariant(self.state))[1]

    @property
    def urgent(self) -> bool:
        """Whether no time may pass: a location is urgent or committed, or an urgent channel is ready."""
        return not self._semantics.may_delay(self.state)

    @property
    def latest(self) -> int | None:
        """The last instant at which the run may still be in this discrete state, µs; None if there is no limit."""
        latest = self.now if self.urgent else self._latest()
        return None if latest == NEVER else latest

    def options(self) -> list[Option]:
        """Return the transitions possible now or after an undisturbed delay, in the order of the file."""
        latest = self.now if self.urgent else self._latest()
        options = []
        for successor in self._successors.at(self.state).successors:
            first, last = successor.window(self._clocks)
            first, last = max(first, self.now), min(last, latest)
            if first <= last:
                end = None if last == NEVER else last
                options.append(Option(successor.transition, first, end, successor.fired))
        return options

    def fire(self, option: Option, at: int) -> TraceStep:
        """Wait until ``at``, an instant at which the option is possible, and take its transition.

        Raises:
            RangeError: a value leaves its range.
        """
        self.now = at
        if isinstance(option.fired, RangeError):
            raise option.fired
        old, (new, resets) = self.state, option.fired
        self.state = new
        self._clocks.set(resets, at)
        channel = option.transition.channel
        return TraceStep(
            at=Fraction(at, US_PER_UNIT),
            channel=None if channel is None else self.network.channels[channel].name,
            edges=option.transition.edges,
            state=new,
            changes=changes_between(self.network, old, new),
        )
