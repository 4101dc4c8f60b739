"""The executor of every mutant behaves differently from that of the shipped file, and the monitor refuses it."""

from __future__ import annotations

import random
from collections.abc import Callable
from functools import cache

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import ModelError, RangeError
from end_effector_hal.vocabulary import ChangerState
from tests.unit.verification.mutants.conftest import MUTANTS, first_of_each
from timed_automata import Event, Execution, Network, Observation, Step
from timed_automata.monitor import Monitor

INTERFACE = load(profile_path()).automata.interface
EXECUTED = ("Gripper", "Actuator", "Changer", "Arming")
EXECUTABLE = [mutant for mutant in MUTANTS if mutant.get("template") in EXECUTED]
SAME = {
    "two attempts only",
    "ON with part of the evidence",
    "the first empty attempt aborts",
    "what was confirmed is taken for empty",
    "a tool that is locked at the start is UNKNOWN until something changes",
    "a start locks although nothing was found active",
}
"""They add a choice. The executor takes the edge that stands first in the file, which is the right one: only the
checker, which looks at every choice, can find them. `taken for empty` takes a moment that random inputs miss: the
last actuator is confirmed, another one has no reading, and then it is empty."""
LEVELS = {"gone": 1, "partial": 2, "confirmed": 3}
LEVELS_ASKED = ("vented", "parked")
COMMANDS = ("grip", "grip", "drop", "cancel", "lock", "unlock")
UNLOCKED, UNLOCKING, LOCKING = ChangerState.UNLOCKED, ChangerState.UNLOCKING, ChangerState.LOCKING
RUNS, INPUTS = 1000, 60


def play(network: Network, seed: int, observe: Callable[[Observation], object] | None = None) -> list[object]:
    """What the executed side puts out for random inputs: the seed decides, and what the outputs ask of the world.

    ``observe`` is called with what a monitor sees.
    """
    execution = Execution(network, EXECUTED, INTERFACE, observe=observe)
    chooser = random.Random(seed)
    told: list[object] = []
    steps = network.constants["N"]
    assert isinstance(steps, int)
    levels = {f"evidence[{i}]": 1 for i in range(steps)} | {"tool": 1}
    active = [chooser.random() < 0.2] * steps
    if active[0] and seed % 2:
        levels |= {f"evidence[{i}]": 3 for i in range(steps)}  # it was gripped when the program started
    # some worlds answer, some keep silent, some lose what was there
    weights = chooser.choice([(2, 9, 3, 1), (8, 2, 2, 1), (5, 6, 3, 3)])
    fitting = chooser.choice([1.0, 0.9, 0.6])
    at = 0
    try:
        execution.start(0)
        adopted = {f"adopted[{i}]": int(active[i]) for i in range(steps)}
        found = {
            name: int(chooser.random() < 0.1) for name in ("adopted_unlock", "adopted_fault", "adopted_error")
        }
        execution.write({**levels, **adopted, **found, "adopted_part": 0})
        told += execution.receive(Event("adopt"), 0).steps
        for _ in range(INPUTS):
            kind = chooser.choices(["wait", "sensor", "command", "tool"], weights)[0]
            if execution.value("changer") in (UNLOCKING, LOCKING) and chooser.random() < 0.3:
                kind = "tool"
            if kind == "wait":
                due = execution.deadline
                late = chooser.choice([0, 0, 0, 20_000, 60_000, 130_000])
                at = max(at, due + late) if due is not None else at + 1_000_000
                told += execution.advance(at)
                continue
            at += chooser.choice([0, 1_000, 20_000, 400_000, 1_900_000, 4_900_000])
            told += execution.run(at - 1)
            if kind == "command":
                asked = {name: int(chooser.random() < 0.9) for name in LEVELS_ASKED}
                told += execution.write(asked, at)
                name, writes = command(execution, chooser), {}
            elif kind == "sensor" and network.constants["SHOWS_EMPTY"] and chooser.random() < 0.3:
                active_now = [i for i in range(steps) if execution.value(f"valve[{i}]")]
                name, writes = f"empty[{max(active_now, default=0)}]", {}
            elif kind == "tool":
                unlocking = execution.value("changer") == UNLOCKING and chooser.random() < 0.7
                level = 2 if unlocking else chooser.choice([1, 1, 1, 1, 1, 1, 2, 0, 3])
                if level in (0, 3) and seed % 4 == 3:
                    level = 4  # in some worlds the tool is absent instead of unclear
                name, writes = f"tool_is[{level}]", {"tool": level}
            else:
                active_now = [execution.value(f"valve[{i}]") for i in range(steps)]
                fits = [3 if on else 1 for on in active_now]
                odd = [i for i in range(steps) if execution.value(f"evidence[{i}]") != fits[i]]
                index = chooser.choice(odd) if odd and chooser.random() < 0.7 else chooser.randrange(steps)
                level = fits[index] if chooser.random() < fitting else chooser.choice((0, 0, 1, 2, 3))
                if level == 0:
                    told += execution.write({f"evidence[{index}]": 0}, at)
                    continue
                word = next(word for word, value in LEVELS.items() if value == level)
                name, writes = f"{word}[{index}]", {f"evidence[{index}]": level}
            told += execution.receive(Event(name, writes), at).steps
    except (RangeError, ModelError) as error:
        told.append(type(error))
    return [
        (step.at, step.sent, step.missed, step.changes) if isinstance(step, Step) else step for step in told
    ]


def command(execution: Execution, chooser: random.Random) -> str:
    """One that is given, or the line arbiter's answer to the one before."""
    if execution.value("changer") in (UNLOCKING, UNLOCKED) and chooser.random() < 0.3:
        return "unlock_refused"
    if execution.value("ee") in (1, 3) and chooser.random() < 0.1:
        return "grip_refused"
    if execution.value("ee") == 6 and chooser.random() < 0.5:
        return "grip"
    return chooser.choice(COMMANDS if chooser.random() < 0.8 else ("unlock", "arm", "reset"))


@pytest.fixture(scope="module")
def expected(shipped) -> Callable[[int], list[object]]:  # type: ignore[no-untyped-def]
    """What the shipped file does, by the seed."""
    network = shipped.network()
    return cache(lambda seed: play(network, seed))


@first_of_each(EXECUTABLE, "template")
def test_the_executor_of_a_mutant_is_found_out(shipped, expected, mutant) -> None:  # type: ignore[no-untyped-def]
    try:
        network = shipped.network(mutant)
        if "constants" in mutant:
            original = shipped.original(mutant)
            differs = any(play(network, seed) != play(original, seed) for seed in range(RUNS))
        else:
            differs = any(play(network, seed) != expected(seed) for seed in range(RUNS))
    except ModelError:
        differs = True  # it cannot be executed at all
    assert differs is (mutant["name"] not in SAME)


# The monitor of the shipped network refuses what the executor of a mutant does.


class Watched:
    """The executions of a test, each with what was seen of it."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.seen: list[Observation] = []
        self.at = 0
        watched = self

        class Recorded(Execution):
            def __init__(self, *args: object, **options: object) -> None:
                watched.seen, watched.at = [], 0
                super().__init__(*args, **options | {"observe": watched.seen.append})  # type: ignore[arg-type]

            def advance(self, at: int) -> tuple[Step, ...]:
                watched.at = at
                return super().advance(at)

        monkeypatch.setattr("tests.unit.verification.mutants.test_executors.Execution", Recorded)


@pytest.fixture
def refused(shipped, monkeypatch):  # type: ignore[no-untyped-def]
    """Whether the monitor of the true network refuses one run of a network, by its seed."""
    watched = Watched(monkeypatch)

    def judge(network, true, seed: int) -> bool:  # type: ignore[no-untyped-def]
        play(network, seed)
        monitor = Monitor(true, EXECUTED, INTERFACE)
        for observation in watched.seen:
            monitor.observe(observation)
        monitor.end(max([watched.at, *(observation.at for observation in watched.seen)]))
        return any(objection.kind == "no run" for objection in monitor.objections)

    return judge


def test_the_shipped_executor_is_accepted(shipped, refused) -> None:  # type: ignore[no-untyped-def]
    network = shipped.network()
    assert not any(refused(network, network, seed) for seed in random.Random(1).sample(range(RUNS), 40))


@first_of_each(EXECUTABLE, "template", thinned="caught_by")
def test_the_executor_of_a_mutant_is_refused(shipped, refused, mutant) -> None:  # type: ignore[no-untyped-def]
    if mutant["name"] in SAME:
        return
    try:
        network = shipped.network(mutant)
        true = shipped.original(mutant)
        assert any(refused(network, true, seed) for seed in range(RUNS))
    except ModelError:
        pass  # it cannot be executed at all
