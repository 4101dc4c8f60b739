"""Guides a simulated run: chooses the next transition by its channel or by its effect, and its time."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction

from timed_automata.document import Text
from timed_automata.errors import UsageError
from timed_automata.language import parse_expression
from timed_automata.network import Network, State
from timed_automata.queries import Data, compile_formula
from timed_automata.simulate._machine import US_PER_UNIT, Option

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
