"""Simulates a network: takes the given choices first, then random transitions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Protocol

from timed_automata.errors import RangeError, UsageError
from timed_automata.network import Network, Trace, TraceStep
from timed_automata.simulate._machine import US_PER_UNIT, Choice, Machine, Option

STEPS = 100
_SPREAD_US = 2_000_000  # over which the instant of a transition is spread where nothing limits it
_MOST_AT_ONCE = 1000  # transitions without a delay between them: more is a livelock
_ENDS = "The run ends here."


class Chooser(Protocol):
    """A source of random numbers: ``random.Random``, or a test."""

    def randrange(self, stop: int, /) -> int:
        """Return a number from 0 to ``stop - 1``."""


@dataclass(frozen=True, slots=True)
class Run:
    """A simulated run.

    Attributes:
        trace: its steps, end and last remark.
        error: a value left its range; the run ends before that transition.
    """

    trace: Trace
    error: RangeError | None = None


def simulate(
    network: Network,
    chooser: Chooser,
    choices: Sequence[Choice] = (),
    *,
    steps: int | None = None,
    until: int | None = None,
) -> Run:
    """Simulate a concrete run from the initial state, with delays that the invariants allow.

    The choices are taken first. Before each choice, transitions that cannot wait (committed and urgent locations,
    urgent channels) are taken at random unless the choice matches one. After the last one, the run continues at
    random.

    Args:
        network: a loaded network.
        chooser: its numbers make all open decisions: the same numbers give the same run.
        choices: see :func:`parse_choices`.
        steps: largest number of steps; by default 100, or with choices those and the transitions after them that
            cannot wait.
        until: latest end of the run, µs since the start.

    Raises:
        UsageError: a choice is not possible at its turn.
        ModelError: the initial state violates an invariant.
    """
    return _Simulation(network, chooser, until).run(choices, steps)


class _Simulation:
    def __init__(self, network: Network, chooser: Chooser, until: int | None) -> None:
        self._machine = Machine(network)
        self._chooser, self._until = chooser, until
        self._taken: list[TraceStep] = []
        self._at_once = 0  # transitions without a delay between them

    def run(self, choices: Sequence[Choice], steps: int | None) -> Run:
        try:
            return self._guided(choices, steps) or self._by_chance(choices, steps)
        except RangeError as error:
            return self._end(error.what, error=error)

    def _end(self, remark: str = _ENDS, at: int | None = None, error: RangeError | None = None) -> Run:
        end = Fraction(self._machine.now if at is None else at, US_PER_UNIT)
        return Run(Trace(self._machine.network, tuple(self._taken), end, remark), error)

    def _take(self, option: Option, at: int) -> Run | None:
        """Take a transition; return the run if it ends before the transition."""
        if self._until is not None and at > self._until:
            return self._end(at=self._until)
        self._at_once = self._at_once + 1 if at == self._machine.now else 0
        if self._at_once > _MOST_AT_ONCE:
            return self._end(f"No end after {_MOST_AT_ONCE} transitions at this instant: time does not pass.")
        self._taken.append(self._machine.fire(option, at))
        return None

    # By choice

    def _guided(self, choices: Sequence[Choice], steps: int | None) -> Run | None:
        for number, choice in enumerate(choices, start=1):
            found = None
            while found is None:
                if steps is not None and len(self._taken) >= steps:
                    return self._end()
                found = self._found(number, choice)
                ended = self._take(*found) if found else self._take_by_chance(self._machine.options())
                if ended:
                    return ended
        return None

    def _found(self, number: int, choice: Choice) -> tuple[Option, int] | None:
        """Return the chosen transition and its instant, or None if another transition must be taken immediately."""
        machine = self._machine
        options = machine.options()
        fitting = [option for option in options if choice.fits(option, machine.state)]
        wanted = choice.instant(machine.now)
        possible = [option for option in fitting if _includes(option, wanted)]
        if possible:
            option = self._one_of(possible)
            return option, option.first if wanted is None else wanted
        if not machine.urgent or not options:
            raise self._impossible(number, choice, options, fitting)
        return None

    def _impossible(
        self, number: int, choice: Choice, options: list[Option], fitting: list[Option]
    ) -> UsageError:
        what = f"Choice {number}, '{choice.text}', is not possible after {len(self._taken)} steps"
        now = f"at {_ms(self._machine.now)} ms"
        if fitting:
            windows = ", ".join(sorted({_window(option) for option in fitting}))
            return UsageError(f"{what}, {now}: it is possible {windows}.")
        names = list(dict.fromkeys(f"{self._name(option)} ({_window(option)})" for option in options))
        listed = "; ".join(names[:12]) + (f"; and {len(names) - 12} more" if len(names) > 12 else "")
        return UsageError(f"{what}, {now}.", todo=f"Possible: {listed or 'nothing'}.")

    def _name(self, option: Option) -> str:
        network, (edges, _, channel) = self._machine.network, option.transition
        if channel is not None:
            return network.channels[channel].name
        process = network.processes[edges[0].process]
        return f"{process.name}.{process.locations[edges[0].target].name}"

    # By chance

    def _by_chance(self, choices: Sequence[Choice], steps: int | None) -> Run:
        guided = bool(choices) and steps is None and self._until is None
        limit = STEPS if steps is None and self._until is None else steps
        while guided or limit is None or len(self._taken) < limit:
            if guided and not self._machine.urgent:
                break
            ended = self._take_by_chance(self._machine.options())
            if ended:
                return ended
        return self._end()

    def _take_by_chance(self, options: list[Option]) -> Run | None:
        if not options:
            return self._stuck()
        option = self._one_of(options)
        last = option.first + _SPREAD_US
        last = last if option.last is None else min(last, option.last)
        return self._take(option, option.first + self._chooser.randrange(last - option.first + 1))

    def _stuck(self) -> Run:
        machine = self._machine
        if machine.latest is None:
            return self._end("Nothing can happen any more; time goes on.", self._until)
        beyond = "" if machine.latest == machine.now else f" beyond {_ms(machine.latest)} ms"
        return self._end(f"Deadlock: nothing can happen, and time may not pass{beyond}.")

    def _one_of(self, options: list[Option]) -> Option:
        """Choose an option at random; all drawn edges are equally likely, however many values they select."""
        drawn: dict[tuple[int, int], list[Option]] = {}
        for option in options:
            first = option.transition.edges[0]
            key = (first.process, id(first.drawn))
            drawn.setdefault(key, []).append(option)
        groups = list(drawn.values())
        group = groups[self._chooser.randrange(len(groups))]
        return group[self._chooser.randrange(len(group))]


def _includes(option: Option, at: int | None) -> bool:
    return at is None or (option.first <= at and (option.last is None or at <= option.last))


def _window(option: Option) -> str:
    if option.last == option.first:
        return f"at {_ms(option.first)} ms"
    return f"from {_ms(option.first)} ms" + ("" if option.last is None else f" to {_ms(option.last)} ms")


def _ms(us: int) -> str:
    return f"{us / US_PER_UNIT:.3f}".rstrip("0").rstrip(".")
