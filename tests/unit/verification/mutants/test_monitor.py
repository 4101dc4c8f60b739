"""The monitor of the shipped network refuses what the executor of a mutant does."""

from __future__ import annotations

import random

import pytest

from end_effector_hal.errors import ModelError
from tests.unit.verification.mutants.mutants import first_of_each
from tests.unit.verification.mutants.test_executors import EXECUTABLE, EXECUTED, INTERFACE, RUNS, SAME, play
from timed_automata import Execution, Observation, Step
from timed_automata.monitor import Monitor


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
