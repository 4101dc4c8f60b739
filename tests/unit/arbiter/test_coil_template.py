"""The line arbiter's code and the network of two coils are held together: what the one does is a run of the other."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cache
from typing import Any

import pytest

from end_effector_hal.arbiter import LineArbiter, Policy
from end_effector_hal.arbiter.records._journal import JournalEntry
from end_effector_hal.arbiter.records._records import recall
from end_effector_hal.arbiter.rules._coils import Coils, SecondCoil
from end_effector_hal.arbiter.rules._session import ArbiterState
from tests.support.nightly import first_of
from tests.unit.arbiter.coil_runs import BACK, JAW, MS, CoilRun, model_text, random_coil_run

HELD = Policy((JAW,), opposites={JAW: SecondCoil(BACK)})
PULSED = Policy((JAW,), opposites={JAW: SecondCoil(BACK, 100 * MS)})
SHORT = Policy((JAW,), opposites={JAW: SecondCoil(BACK, 20 * MS)})
PAUSED = Policy((JAW,), opposites={JAW: SecondCoil(BACK, 20 * MS, 90 * MS)})
SEEDS = range(40)


@pytest.mark.parametrize("seed", first_of(SEEDS, 1, 2))
@pytest.mark.parametrize("policy", [HELD, PULSED, SHORT, PAUSED], ids=["held", "pulsed", "short", "paused"])
def test_what_the_line_arbiter_does_is_a_run_of_the_network(policy: Policy, seed: int) -> None:
    assert random_coil_run(policy, seed).is_one_of(model_text())


@cache
def right_steps() -> list[Any]:
    """What an arbiter without a fault does, which the test above proves; in `make test` of the first seeds."""
    return [random_coil_run(PULSED, seed).steps for seed in SEEDS]


def all_are_runs(runs: Iterable[CoilRun], **constants: int) -> bool:
    """Whether the network has all runs; those of an arbiter without a fault need not be explored for each fault."""
    other = [run for run, right in zip(runs, right_steps(), strict=True) if run.steps != right]
    return all(run.is_one_of(model_text(), **constants) for run in other)


def believes_all(record: ArbiterState | None, journal: JournalEntry) -> ArbiterState:
    """As if no journal lagged behind."""
    return replace(recall(record, journal), pulsed=journal.pulsed)


def forgets(record: ArbiterState | None, journal: JournalEntry) -> ArbiterState:
    """Nothing is known of pulsed outputs."""
    return replace(recall(record, journal), pulsed={})


@pytest.mark.parametrize("believes", first_of([believes_all, forgets]))
def test_an_arbiter_that_believes_other_records_is_found_out(believes: Callable[..., ArbiterState]) -> None:
    assert not all_are_runs(random_coil_run(PULSED, seed, believes) for seed in SEEDS)


@pytest.mark.parametrize(
    "other",
    first_of(
        [
            replace(PULSED, opposites={JAW: SecondCoil(BACK, 90 * MS)}),
            replace(PULSED, opposites={JAW: SecondCoil(BACK, 110 * MS)}),
            replace(PULSED, min_switch_us=40 * MS),
        ]
    ),
    ids=["shorter pulse", "longer pulse", "shorter pause"],
)
def test_another_length_is_found_out(other: Policy) -> None:
    assert not all_are_runs((random_coil_run(other, seed) for seed in SEEDS), PULSE=100, SWITCH=50)


@pytest.mark.thinned  # long
def test_another_pause_after_a_pulse_is_found_out() -> None:
    other = replace(PAUSED, opposites={JAW: SecondCoil(BACK, 20 * MS, 80 * MS)})
    assert not all(random_coil_run(other, seed).is_one_of(model_text(), PAUSE=90) for seed in SEEDS)


def _ends_found_pulses_at_once(self: Coils, lines: Any, believed: Any, at: int) -> dict[str, bool]:
    return REQUEST(self, lines, believed, at - 100 * MS)


def _cuts_and_believes(self: Coils) -> None:
    self.advance(2**63 - 1)


def _goes_on(self: LineArbiter, session: Any, why: str, at: int) -> None:
    session.will = ()
    DECLARE_DEAD(self, session, why, at)


REQUEST, DECLARE_DEAD = Coils.request, LineArbiter.declare_dead


@pytest.mark.parametrize(
    ("where", "name", "wrong"),
    [
        (Coils, "request", _ends_found_pulses_at_once),
        (Coils, "cut", _cuts_and_believes),
        pytest.param(LineArbiter, "declare_dead", _goes_on, marks=pytest.mark.thinned),
    ],
)
def test_an_arbiter_that_does_something_else_is_found_out(
    monkeypatch: pytest.MonkeyPatch, where: type, name: str, wrong: Callable[..., Any]
) -> None:
    right_steps()
    monkeypatch.setattr(where, name, wrong)
    assert not all_are_runs(random_coil_run(PULSED, seed) for seed in SEEDS)
