"""Timed trace inclusion on random tiny networks, against a search that tries every half unit of time.

The search knows the networks as they were drawn, not as they were compiled, and shares no code with what it is held
against. It steps in halves (then in quarters and eighths), and so finds fewer differences, never one that is none.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from operator import eq, ge, gt, le, lt
from random import Random
from typing import NamedTuple

import pytest

from tests.support.nightly import NIGHTLY, examples
from tests.unit.timed_automata.explore.models import network
from timed_automata import Network
from timed_automata.errors import ModelError
from timed_automata.inclusion import Inclusion, Interface, trace_inclusion

pytestmark = pytest.mark.timeout(3600 if NIGHTLY else 120)
LARGEST = 3
OPS = {"<": lt, "<=": le, "==": eq, ">=": ge, ">": gt}
INPUTS, OUTPUTS = ("go", "stop"), ("on", "off", "")


@dataclass(frozen=True)
class Way:
    """An edge: of the system on an input (no clock), or with an output; of the environment with an input."""

    source: int
    target: int
    channel: str
    guard: tuple[str, int] | None
    reset: int | None  # what the clock is set to
    value: int | None  # what the observed variable is set to
    level: int | None  # what the input variable is asked for, or set to

    def allows(self, clock: float) -> bool:
        return self.guard is None or OPS[self.guard[0]](clock, self.guard[1])

    def text(self, clock: str, *, sends: bool, system: bool) -> str:
        guards = [f"{clock} {self.guard[0]} {self.guard[1]}"] if self.guard else []
        updates = [f"{clock} = {self.reset}"] if self.reset is not None else []
        updates += [f"i = {self.value}"] if self.value is not None else []
        if self.level is not None:
            (guards if system else updates).append(f"e == {self.level}" if system else f"e = {self.level}")
        parts = [f"l{self.source} -> l{self.target}"]
        parts += [f"guard: {' && '.join(guards)}"] if guards else []
        parts += [f"sync: {self.channel}{'!' if sends else '?'}"] if self.channel else []
        parts += [f"do: {', '.join(updates)}"] if updates else []
        return "; ".join(parts)


@dataclass(frozen=True)
class Part:
    """An automaton of three locations with one clock."""

    ways: tuple[Way, ...]
    invariants: tuple[tuple[str, int] | None, ...]

    def holds(self, place: int, clock: float) -> bool:
        bound = self.invariants[place]
        return bound is None or OPS[bound[0]](clock, bound[1])

    def template(self, name: str, clock: str) -> str:
        system = name == "System"
        held = [f"l{at}: {clock} {bound[0]} {bound[1]}" for at, bound in enumerate(self.invariants) if bound]
        ways = [
            way.text(clock, sends=way.channel not in INPUTS or not system, system=system) for way in self.ways
        ]
        return " | ".join(
            [f"{name}: own: clock {clock};", "initial: l0", "locations: l0 l1 l2", *held, *ways]
        )


def built(system: Part, environment: Part) -> Network:
    declarations = "int[0, 3] i; int[0, 1] e; broadcast chan go, stop, on, off;"
    return network(declarations, system.template("System", "x"), environment.template("World", "y"))


class Drawn:
    """Random automata, and edits of them."""

    def __init__(self, seed: int) -> None:
        self.random = Random(seed)

    def guard(self) -> tuple[str, int] | None:
        return self.random.choice((None, (self.random.choice(list(OPS)), self.random.randint(0, LARGEST))))

    def bound(self) -> tuple[str, int] | None:
        return self.random.choice((None, None, ("<=", self.random.randint(1, LARGEST)), ("<", LARGEST)))

    def level(self) -> int | None:
        return self.random.choice((None, None, 0, 1))

    def value(self) -> int:
        return self.random.randint(0, LARGEST)

    def way(self, channels: Sequence[str]) -> Way:
        source, target, reset = (
            self.random.randint(0, 2),
            self.random.randint(0, 2),
            self.random.choice((None, 0, 0, 1, 2)),
        )
        channel = self.random.choice(channels)
        if channel in INPUTS:
            value = self.random.choice((None, self.value()))
            return Way(source, target, channel, None, reset, value, self.level())
        return Way(source, target, channel, self.guard(), reset, self.value(), self.level())

    def system(self) -> Part:
        ways = [self.way(INPUTS) for _ in range(self.random.randint(1, 3))]
        ways += [self.way(OUTPUTS) for _ in range(self.random.randint(1, 3))]
        return Part(tuple(ways), (self.bound(), self.bound(), self.bound()))

    def environment(self) -> Part:
        """It can always go on: in each location it sends something."""
        sent = [
            replace(self.way(INPUTS), source=at, guard=self.guard(), reset=0, value=None) for at in range(3)
        ]
        return Part(tuple(sent), (None, None, self.bound()))

    def edited(self, part: Part) -> Part:
        """The same with one edit."""
        at = self.random.randrange(len(part.ways))
        way, ways = part.ways[at], list(part.ways)
        kind = self.random.choice(
            ("drop", "reset", "target", "value", "guard", "guard", "invariant", "add", "level")
        )
        if kind == "drop":
            del ways[at]
        elif kind == "invariant":
            bounds = list(part.invariants)
            bounds[self.random.randint(0, 2)] = self.bound()
            return replace(part, invariants=(bounds[0], bounds[1], bounds[2]))
        elif kind == "add":
            ways.append(self.way(OUTPUTS))
        elif kind == "reset":
            ways[at] = replace(way, reset=0 if way.reset is None else None)
        elif kind == "target":
            ways[at] = replace(way, target=self.random.randint(0, 2))
        elif kind == "value":
            ways[at] = replace(way, value=self.value())
        elif kind == "level":
            ways[at] = replace(way, level=self.level())
        elif way.channel not in INPUTS:
            ways[at] = replace(way, guard=self.guard())
        return replace(part, ways=tuple(ways))


# The search


class At(NamedTuple):
    """A state of a system: location, observed variable, clock."""

    place: int
    value: int
    clock: float


class Point(NamedTuple):
    ours: At
    theirs: frozenset[At]
    place: int  # of the environment
    clock: float
    level: int


def taken(part: Part, at: At, way: Way) -> At | None:
    value = at.value if way.value is None else way.value
    clock = at.clock if way.reset is None else float(way.reset)
    return At(way.target, value, clock) if part.holds(way.target, clock) else None


def outputs(part: Part, at: At, level: int) -> Iterator[tuple[tuple[str, int], At]]:
    for way in part.ways:
        if way.channel not in INPUTS and way.source == at.place and way.allows(at.clock):
            after = taken(part, at, way)
            if (way.level is None or way.level == level) and after is not None:
                yield (way.channel, after.value), after


def answers(part: Part, at: At, level: int, channel: str) -> list[At]:
    ready = [
        way
        for way in part.ways
        if way.channel == channel and way.source == at.place and (way.level is None or way.level == level)
    ]
    found = [taken(part, at, way) for way in ready]
    return [after for after in found if after is not None] if ready else [at]


class Naive:
    def __init__(self, ours: Part, theirs: Part, world: Part, step: float) -> None:
        self.ours, self.theirs, self.world, self.step = ours, theirs, world, step

    def differ(self) -> bool:
        start = Point(At(0, 0, 0.0), frozenset([At(0, 0, 0.0)]), 0, 0.0, 0)
        waiting, passed = deque([start]), {start}
        while waiting:
            for after in self._after(waiting.popleft()):
                if after is None or not after.theirs:
                    return True
                if after not in passed:
                    passed.add(after)
                    waiting.append(after)
        return False

    def _after(self, at: Point) -> Iterator[Point | None]:
        """What follows; None, or nothing on their side: a difference."""
        later = self._later(at)
        if later is not None:
            yield later
        for seen, after in outputs(self.ours, at.ours, at.level):
            if seen == ("", at.ours.value):
                yield at._replace(ours=after)  # nothing is seen
                continue
            theirs = {
                to for one in at.theirs for also, to in outputs(self.theirs, one, at.level) if also == seen
            }
            yield at._replace(ours=after, theirs=frozenset(theirs))
        for way in self.world.ways:
            if way.source == at.place and way.allows(at.clock) and self.world.holds(way.target, 0.0):
                yield from self._input(at, way)

    def _later(self, at: Point) -> Point | None:
        def passed(clock: float) -> float:
            return min(clock + self.step, LARGEST + 1)

        ours, clock = at.ours._replace(clock=passed(at.ours.clock)), passed(at.clock)
        if not (self.ours.holds(ours.place, ours.clock) and self.world.holds(at.place, clock)):
            return None
        moved = [one._replace(clock=passed(one.clock)) for one in at.theirs]
        allowed = frozenset(one for one in moved if self.theirs.holds(one.place, one.clock))
        return at._replace(ours=ours, theirs=allowed, clock=clock)

    def _input(self, at: Point, way: Way) -> Iterator[Point | None]:
        level = at.level if way.level is None else way.level
        theirs = [after for one in at.theirs for after in answers(self.theirs, one, at.level, way.channel)]
        if not theirs:
            return  # not in this world
        ours = answers(self.ours, at.ours, at.level, way.channel)
        if not ours:
            yield None
        for one in ours:
            alike = frozenset(other for other in theirs if other.value == one.value)
            yield Point(one, alike, way.target, 0.0, level)


# Both


def decided(ours: Part, theirs: Part, world: Part) -> Inclusion:
    interface = Interface(["World"], ["i"], ["on", "off"])
    return trace_inclusion(built(ours, world), built(theirs, world), interface)


def test_inclusion_is_what_a_search_in_small_steps_finds() -> None:
    met = Counter[str]()
    for seed in range(examples(150, 5000)):
        drawn = Drawn(seed)
        theirs, world = drawn.system(), drawn.environment()
        ours = drawn.edited(drawn.edited(theirs))
        try:
            assert decided(theirs, theirs, world).holds
            found = decided(ours, theirs, world)
        except ModelError:  # the specification is not deterministic
            met["refused"] += 1
            continue
        met[str(found.holds)] += 1
        steps = (0.5,) if found.holds else (0.5, 0.25, 0.125)
        differ = any(Naive(ours, theirs, world, step).differ() for step in steps)
        assert differ is not found.holds, (seed, ours, theirs, world, found.lines)
    assert min(met["True"], met["False"]) > 20, met
