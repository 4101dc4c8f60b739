"""The line arbiter with its disk, its client and the program: any of them dies or fails at any time."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from end_effector_hal.arbiter.client import _client
from end_effector_hal.arbiter.records import _session_store
from end_effector_hal.arbiter.rules import _arbiter, _predicates
from end_effector_hal.arbiter.rules._arbiter import LineArbiter
from tests.support.nightly import first_of
from tests.unit.arbiter.simulation.simulation import Met, play, table
from tests.unit.arbiter.simulation.world import CHANGES, FAULTS

RUNS, PARTS = 2_000, 32
EACH = RUNS // PARTS
"""Of a part; `make test` plays one, `make test-thinned` four, `make nightly` the others and 100,000 with run.py."""


@pytest.mark.timeout(600)
@pytest.mark.parametrize("part", first_of(range(PARTS), 1, 4))
def test_nothing_falls_no_latch_is_lost_and_the_next_program_can_work(part: int) -> None:
    met: Met = Counter()
    violated = play(range(part * EACH, (part + 1) * EACH), met)
    sys.stdout.write(f"{table(met)}\n")
    assert not violated, violated
    assert {fault for fault, _ in met} == {*FAULTS, CHANGES}
    assert met[CHANGES, "refused"]
    assert met[CHANGES, "accepted"]
    assert len(met) > 75


def test_a_seed_replays_its_run() -> None:
    first: Met = Counter()
    second: Met = Counter()
    for met in (first, second):
        play([1234], met)
    assert first == second


# Repairs undone: each must be found within these runs

Patch = Callable[[Any, str, Any], None]


def a_record_that_is_switched_off_after_a_failure(patch: Patch) -> None:
    """It stays as it is and looks valid: what the journal once did."""
    whole = _session_store.SessionStore.keep

    def keep(self: Any, memory: Any) -> None:
        if not self.trouble:
            whole(self, memory)

    def fail(self: Any, error: OSError) -> None:
        self.trouble = str(error)

    patch(_session_store.SessionStore, "keep", keep)
    patch(_session_store.SessionStore, "_fail", fail)
    patch(_session_store.SessionStore, "begin", lambda _: None)
    patch(LineArbiter, "_changed_meanwhile", lambda *_: "")


def a_token_that_two_programs_share(patch: Patch) -> None:
    """As the pid 0 of all who come from other PID namespaces."""
    patch(_client, "make_token", lambda: "0" * 32)


def a_table_of_faults_that_clients_can_fill(patch: Patch) -> None:
    """One place in all, which the first fault takes."""

    def latch(self: Any, name: str, why: str) -> None:
        if not self.faults:
            self.faults[name] = why

    patch(_predicates.SensorPredicates, "latch", latch)


def a_last_will_that_is_executed_in_doubt(patch: Patch) -> None:
    whole = LineArbiter._resume
    patch(LineArbiter, "_resume", lambda self, memory, at: whole(self, _certain(memory), at))


def a_line_that_is_forgotten_when_the_description_changes(patch: Patch) -> None:
    patch(_arbiter, "left_behind", lambda *_: "")


def _certain(memory: Any) -> Any:
    return replace(memory, doubt="", levels={})


@pytest.mark.timeout(600)
@pytest.mark.parametrize(
    ("undo", "first"),
    [
        (a_record_that_is_switched_off_after_a_failure, 17),
        (a_token_that_two_programs_share, 111),
        (a_table_of_faults_that_clients_can_fill, 680),
        (a_last_will_that_is_executed_in_doubt, 111),
        (a_line_that_is_forgotten_when_the_description_changes, 8),
    ],
)
def test_a_repair_that_is_undone_is_found(undo: Callable[[Patch], None], first: int) -> None:
    """``first`` is a seed that finds it today; another world looks further."""
    assert play(range(first, first + RUNS), Counter(), most=1, undo=undo)
