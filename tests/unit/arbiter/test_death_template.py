"""The line arbiter's code and the network of deaths are held together: what the one does is a run of the other."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import pytest

from end_effector_hal.arbiter import LineArbiter
from end_effector_hal.arbiter.server import _requests
from tests.support.nightly import NIGHTLY, first_of
from tests.unit.arbiter import death_runs
from tests.unit.arbiter.death_runs import ApartLines, DeathRun, model_text, random_death_run
from tests.unit.arbiter.simulation import process

pytestmark = pytest.mark.thinned  # long

SEEDS, MORE = range(40 if NIGHTLY else 6), range(250)


def played(seed: int, monkeypatch: pytest.MonkeyPatch) -> DeathRun:
    worlds: list[DeathRun] = []
    begin = DeathRun.__init__

    def note(self: DeathRun, seed: int) -> None:
        begin(self, seed)
        worlds.append(self)

    with monkeypatch.context() as patch:
        patch.setattr(DeathRun, "__init__", note)
        patch.setattr(_requests, "now_us", lambda: worlds[-1].now)
        patch.setattr(process, "Lines", ApartLines)
        return random_death_run(seed)


@pytest.mark.parametrize("seed", first_of(SEEDS, 2, 0))
def test_what_the_line_arbiter_does_is_a_run_of_the_network(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = played(seed, monkeypatch)
    assert not run.fell
    assert run.is_one_of(model_text())


@cache
def right_steps() -> list[Any]:
    """What an arbiter without a fault does."""
    with pytest.MonkeyPatch.context() as patch:
        return [played(seed, patch).steps for seed in MORE]


def all_are_runs(monkeypatch: pytest.MonkeyPatch) -> bool:
    """Whether the network has all runs; those of an arbiter without a fault need not be explored for each fault."""
    runs = [played(seed, monkeypatch) for seed in MORE]
    other = [run for run, right in zip(runs, right_steps(), strict=True) if run.steps != right]
    return all(run.is_one_of(model_text()) for run in other)


def _lets_in(self: LineArbiter, *args: Any, **more: Any) -> Any:
    """Another program, while a last will is being carried out."""
    ended = [each for each in self.sessions if each.ended]
    self.sessions = [each for each in self.sessions if not each.ended]
    session = HELLO(self, *args, **more)
    self.sessions += ended
    return session


def _inactive(self: ApartLines, names: object) -> dict[str, bool]:
    """All lines become inactive outputs at a start."""
    self.set({name: False for name, level in self.levels().items() if level})
    return self.levels()


HELLO = LineArbiter.hello


@pytest.mark.parametrize(
    "fault",
    first_of(
        [
            (ApartLines, "request", _inactive),
            (LineArbiter, "hello", _lets_in),
            (death_runs, "POLICY", replace(death_runs.POLICY, min_switch_us=40_000)),
        ],
        thinned=0,
    ),
)
def test_an_arbiter_that_does_something_else_is_found_out(
    monkeypatch: pytest.MonkeyPatch, fault: tuple[Any, str, Any]
) -> None:
    """One that believes an outdated record shows in none of these runs: `test_next_arbiter` finds it."""
    right_steps()
    monkeypatch.setattr(*fault)
    assert not all_are_runs(monkeypatch)
