"""Draws random cases, each from its own small selection of kinds of events (a swarm) or as a mutant of a kept case, and
finds the smallest case that still fails for the same reason.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from random import Random

from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_lab.testbench import parse_scenario

from ._case import (
    ARBITER,
    DISK,
    END,
    HAL,
    KILL,
    NOMINAL,
    POWER,
    SCENARIO,
    START,
    STORES,
    TROUBLES,
    Case,
    Happening,
)
from ._coverage import CoverageMap
from ._grid import faults_of, grip_of
from ._play import play_case

MOST_HAPPENINGS, LONGEST_US = 14, 60_000_000
NEAR_US = 1_000
COMMANDS_SHARE = 3
"""Weight of commands; faults have one to three, deaths one or two."""
WEIGHTS = {"grip": 8, "drop": 5, "cancel": 3, "lock": 2, "unlock": 3, "arm": 1, "reset": 2}
"""The commands that are drawn; a resume stands in cases that were written by hand."""
KILLED = (HAL, ARBITER, "all")
Draw = Callable[[Random], list[tuple[int, str]]]
"""Returns events that belong together: the time after the previous one in µs, and the event."""


class CaseSource:
    """Draws cases for a tool.

    Args:
        description: provides the faults, processes and times.
    """

    def __init__(self, description: Description) -> None:
        self._description = description
        self._faults: dict[str, list[str]] = {}
        for fault in faults_of(description):
            if fault != NOMINAL:
                self._faults.setdefault(fault.partition(":")[0], []).append(fault)
        actuators = [actuator for _, actuator in description.ordered]
        seconds = {0.02, 0.05, 0.1, 0.15, 1.0, *(each.timeout_s for each in actuators)}
        seconds |= {each.reset_s for each in actuators} | {each.release_s for each in actuators}
        if changer := description.tool_changer:
            seconds |= {changer.unlock_max_s, changer.prove_s, changer.fault_s, changer.vented_s}
        self._deadlines = sorted(round(each * 1e6) for each in seconds)

    def fresh(self, random: Random) -> Case:
        """Return a new case from its own selection: a few kinds of events, a few faults."""
        kinds = self._swarm(random)
        if random.random() < 0.5:
            return self._disturbed_grip(random, kinds)
        happenings, at = list[Happening](), 0
        if random.random() < 0.6:
            happenings.append(Happening(0, self._grip(random)))
        while len(happenings) < random.randint(2, MOST_HAPPENINGS) and at < LONGEST_US:
            for gap, what in random.choice(kinds)(random):
                at += gap
                happenings.append(Happening(at, what))
        return Case(random.getrandbits(31), ()).with_(happenings)

    def _grip(self, random: Random) -> str:
        """Return the command that grips some part."""
        parts = list(self._description.parts)
        return grip_of(random.choice(parts)) if parts else "grip"

    def _disturbed_grip(self, random: Random, kinds: Sequence[Draw]) -> Case:
        """Return a grip and perhaps a drop, with a few events at any time in them."""
        drop_at = random.randint(1_000_000, 4_000_000)
        rarely_commands = [*dict.fromkeys(kinds), *kinds[COMMANDS_SHARE:]]
        happenings = [Happening(0, self._grip(random))]
        if random.random() < 0.6:
            happenings.append(Happening(drop_at, "drop"))
        for _ in range(random.randint(1, 3)):
            at = random.randint(0, drop_at + 2_000_000)
            for place, (gap, what) in enumerate(random.choice(rarely_commands)(random)):
                at += gap if place else 0
                happenings.append(Happening(at, what))
        return Case(random.getrandbits(31), ()).with_(happenings)

    def mutant(self, random: Random, case: Case, moments: Sequence[int], other: Case) -> Case:
        """Return a slightly changed case; ``moments`` are the times at which something moved in it, µs."""
        happenings = list(case.happenings)
        for _ in range(random.randint(1, 3)):
            self._mutate(random, happenings, moments, other)
        seed = random.getrandbits(31) if random.random() < 0.2 else case.seed
        kept = [each for each in happenings if each.at <= LONGEST_US][: 2 * MOST_HAPPENINGS]
        return Case(seed, ()).with_(kept or case.happenings)

    def _mutate(
        self, random: Random, happenings: list[Happening], moments: Sequence[int], other: Case
    ) -> None:
        choice = random.randrange(6)
        if choice == 0 and len(happenings) > 1:
            happenings.pop(random.randrange(len(happenings)))
        elif choice == 1 and happenings:
            place = random.randrange(len(happenings))
            happenings[place] = happenings[place]._replace(at=self._moment(random, happenings, moments))
        elif choice == 2 and other.happenings:
            cut = random.choice(other.happenings).at
            begun = self._moment(random, happenings, moments)
            happenings[:] = [each for each in happenings if each.at <= begun]
            happenings += [
                each._replace(at=each.at - cut + begun) for each in other.happenings if each.at >= cut
            ]
        elif choice == 3 and happenings:
            place = random.randrange(len(happenings))
            shift = self._gap(random) - happenings[place].at // 2
            happenings[place:] = [each._replace(at=max(0, each.at + shift)) for each in happenings[place:]]
        else:
            at = self._moment(random, happenings, moments)
            for gap, what in random.choice(self._swarm(random))(random):
                at += gap
                happenings.append(Happening(at, what))

    def _moment(self, random: Random, happenings: Sequence[Happening], moments: Sequence[int]) -> int:
        """Return a time at which something moved, or a deadline after it, exactly or a millisecond earlier or later;
        sometimes any time.
        """
        times = [*moments, *(each.at for each in happenings)]
        if not times or random.random() < 0.2:
            return random.randint(0, 10_000_000)
        at = random.choice(times) + (random.choice(self._deadlines) if random.random() < 0.4 else 0)
        return max(0, at + random.choice((-NEAR_US, 0, 0, NEAR_US)))

    def _gap(self, random: Random) -> int:
        """Return the time between two events, µs: often zero, short, or near a deadline."""
        choice = random.random()
        if choice < 0.1:
            return 0
        if choice < 0.35:
            return random.randint(0, 400_000)
        if choice < 0.7:
            return random.randint(0, 2_500_000)
        if choice < 0.9:
            return max(0, random.choice(self._deadlines) + random.choice((-NEAR_US, 0, NEAR_US)))
        return random.randint(0, 9_000_000)

    def _swarm(self, random: Random) -> list[Draw]:
        """Return a few kinds of events."""
        commands = [name for name in WEIGHTS if name == "grip" or random.random() < 0.5]
        names = random.sample([*self._faults], min(len(self._faults), random.randint(1, 5)))
        faults = [random.choice(self._faults[name]) for name in names]
        killed = random.sample(KILLED, random.randint(1, 2))
        kinds: list[Draw] = []

        def command(random: Random) -> list[tuple[int, str]]:
            name = random.choices(commands, [WEIGHTS[each] for each in commands])[0]
            return [(self._gap(random), self._grip(random) if name == "grip" else name)]

        def fault(random: Random) -> list[tuple[int, str]]:
            return [(self._gap(random), f"{SCENARIO} {self._scenario(random, faults)}")]

        def death(random: Random) -> list[tuple[int, str]]:
            name, verb = random.choice(killed), KILL if random.random() < 0.8 else END
            again = [] if random.random() < 0.15 else [(self._gap(random), f"{START} {name}")]
            return [(self._gap(random), f"{verb} {name}"), *again]

        def disk(random: Random) -> list[tuple[int, str]]:
            return [(self._gap(random), f"{DISK} {random.choice(STORES)} {random.choice(TROUBLES)}")]

        kinds += [command] * COMMANDS_SHARE
        if random.random() < 0.7:
            kinds += [fault] * random.randint(1, 3)
        if random.random() < 0.6:
            kinds += [death] * random.randint(1, 2)
        if random.random() < 0.15:
            kinds += [disk]
        if random.random() < 0.08:
            kinds += [lambda random: [(self._gap(random), POWER)]]
        return kinds

    def _scenario(self, random: Random, faults: Sequence[str]) -> str:
        if random.random() < 0.25:
            return NOMINAL
        if random.random() < 0.75:
            return random.choice(faults)
        both = ",".join(random.sample(faults, min(2, len(faults))))
        try:
            parse_scenario(both, self._description)
        except UsageError:  # they contradict each other
            return random.choice(faults)
        return both


MOST_PLAYS = 300
MOST_S = 60.0
"""Longest time for shrinking, s: one play of a large tool takes seconds, and the smallest case found by then is
useful.
"""


def shrunk(
    description: Description, case: Case, same: Callable[[Mapping[str, str]], bool], known: CoverageMap
) -> Case:
    """Return the smallest case found within `MOST_S` for whose failures ``same`` is true; it is true for the case
    itself.
    """
    until = time.monotonic() + MOST_S

    def fails(tried: Case) -> bool:
        return time.monotonic() < until and same(play_case(description, tried, known, enough=same).failures)

    return shrunk_by(case, fails)


def shrunk_by(case: Case, fails: Callable[[Case], bool], most: int = MOST_PLAYS) -> Case:
    """Return the smallest case found for which ``fails`` is true, with at most ``most`` calls; it is true for
    ``case``.
    """
    asked: dict[Case, bool] = {case: True}

    def asks(tried: Case) -> bool:
        if tried not in asked:
            asked[tried] = len(asked) <= most and fails(tried)
        return asked[tried]

    return _with_fewer(case, asks)


def _with_fewer(case: Case, fails: Callable[[Case], bool]) -> Case:
    """Leave out halves, then quarters, down to single events: delta debugging (Zeller and Hildebrandt, 2002)."""
    left, parts = case.happenings, 2
    while left:
        parts = min(parts, len(left))
        size = -(-len(left) // parts)
        for at in range(0, len(left), size):
            fewer = left[:at] + left[at + size :]
            if fails(Case(case.seed, fewer)):
                left, parts = fewer, max(parts - 1, 2)
                break
        else:
            if parts >= len(left):
                break
            parts *= 2
    return Case(case.seed, left)
