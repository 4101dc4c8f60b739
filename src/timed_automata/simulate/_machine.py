"""A network in one concrete state, and the choice of its next transition.

The machine finds the possible transitions with their times, and takes one. A choice names it by its channel or by its
effect, and gives its time.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import NamedTuple

from timed_automata.document import Text
from timed_automata.errors import ModelError, RangeError, UsageError
from timed_automata.execute import NEVER, ClockInstants, SuccessorCache
from timed_automata.language import parse_expression
from timed_automata.network import Fired, Network, Semantics, State, TraceStep, Transition, changes_between
from timed_automata.queries import Data, compile_formula

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
            first, last = self._clocks.window(successor.bounds)
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


_TIMED = re.compile(r"(?P<what>.*?)(?:(?P<sign>[@+])\s*(?P<ms>\d+(?:\.\d+)?)\s*(?:ms)?)?", re.DOTALL)
_LONGEST_US = 10**13
_NAME = re.compile(r"\w+(\s*\[.*\])?", re.DOTALL)
_Holds = Callable[[State], bool]


@dataclass(frozen=True, slots=True)
class Choice:
    """One step of a guided run.

    Attributes:
        text: the text of the choice.
        channel: number of the channel, if the transition is chosen by its channel.
        holds: otherwise the condition that the transition makes true.
        at: time since the start, µs; None: as soon as possible.
        after: time since the previous step, µs; None: as soon as possible.
    """

    text: str
    channel: int | None = None
    holds: _Holds | None = field(default=None, repr=False)
    at: int | None = None
    after: int | None = None

    def fits(self, option: Option, state: State) -> bool:
        """Return whether a transition out of ``state`` matches the choice, without its time."""
        if self.holds is None:
            return option.transition.channel == self.channel
        if not isinstance(option.fired, tuple):
            return False
        return not self.holds(state) and self.holds(option.fired.state)

    def instant(self, now: int) -> int | None:
        """Return the chosen instant, µs since the start; None: as soon as possible."""
        return now + self.after if self.after is not None else self.at


def parse_choices(network: Network, text: str) -> tuple[Choice, ...]:
    """Parse choices: ``world == IN_TIME; adopt; grip @ 1000; confirmed[0] + 350; Gripper.Gripped``.

    Choices are separated by ``;``. A choice is the name of a channel, or a condition of UPPAAL's query language that
    the transition makes true. ``@`` is followed by the time since the start, ``+`` by the time since the previous
    step, in ms.

    Raises:
        UsageError: a time is not valid, or the condition names a clock.
        ModelError: a condition does not type-check.
    """
    return tuple(_choice(network, item.strip()) for item in text.split(";") if item.strip())


def _choice(network: Network, text: str) -> Choice:
    found = _TIMED.fullmatch(text)
    assert found is not None
    what, sign = found["what"].strip(), found["sign"]
    if not what:
        todo = "Write for instance 'grip @ 1000'."
        raise UsageError(f"'{text}' has a time and no choice.", todo=todo)
    if "@" in what:
        raise UsageError(
            f"'{text}' does not end with a time in ms.", todo="Write for instance 'grip @ 1000'."
        )
    # so many digits Python refuses to read
    us = Fraction(found["ms"][: sys.int_info.default_max_str_digits]) * US_PER_UNIT if sign else Fraction(0)
    if us > _LONGEST_US:
        todo = f"A run has at most {_LONGEST_US // US_PER_UNIT} ms."
        raise UsageError(f"The time in '{text[:80]}' is too long.", todo=todo)
    if us.denominator != 1:
        raise UsageError(f"The time in '{text[:80]}' is finer than a microsecond.")
    at, after = (int(us) if sign == "@" else None), (int(us) if sign == "+" else None)
    channel = _channel(network, what)
    if channel is not None:
        return Choice(text, channel=channel, at=at, after=after)
    return Choice(text, holds=_condition(network, what), at=at, after=after)


def _channel(network: Network, what: str) -> int | None:
    names = {channel.name: number for number, channel in enumerate(network.channels)}
    return names.get("".join(what.split())) if _NAME.fullmatch(what) else None


def _condition(network: Network, what: str) -> _Holds:
    formula = compile_formula(network, parse_expression(Text.plain(what, "choice")))
    if not isinstance(formula, Data):
        raise UsageError(f"'{what}' names a clock.", todo="Choose by channels, locations and variables.")
    return lambda state: bool(formula.cases(state))
