"""Systematic mutants of the shipped automata: what no requirement notices is named here, with its reason."""

from __future__ import annotations

from dataclasses import replace

import pytest

from end_effector_hal.control import model_constants
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import UsageError
from end_effector_hal.runtime import load_automata
from end_effector_hal.verification.mutation import Baseline, MutantOutcome, judge, judge_all
from tests.support.nightly import NIGHTLY
from timed_automata import make_network
from timed_automata.mutate import mutants

EXECUTED = ("Gripper", "Actuator", "Changer", "Arming")
SAMPLE = 300 if NIGHTLY else 30
FREEDOM: dict[str, str] = {}
"""Edits that no requirement notices, and why none needs to."""


@pytest.fixture(scope="module")
def tool():  # type: ignore[no-untyped-def]
    return load(profile_path())


@pytest.mark.timeout(7200)
def test_a_requirement_notices_each_edit(tool) -> None:  # type: ignore[no-untyped-def]
    network, constants = load_automata(tool), model_constants(tool)
    jobs = None if NIGHTLY else 1
    found = list(judge_all(network, constants, EXECUTED, sample=SAMPLE, seed=2026, jobs=jobs))
    assert len(found) == SAMPLE
    survivors = {str(each.mutant) for each in found if each.outcome == MutantOutcome.SURVIVES}
    assert survivors - FREEDOM.keys() == set()
    caught = [each for each in found if each.outcome == MutantOutcome.CAUGHT]
    assert len(caught) > SAMPLE / 2  # the others: switched off by the constants of this tool, or no model


def test_a_requirement_that_is_taken_away_lets_its_mutant_live(tool) -> None:  # type: ignore[no-untyped-def]
    """The judge says that nothing notices where nothing does."""
    network, constants = load_automata(tool), model_constants(tool)
    edit = next(
        each
        for each in mutants(network.document, ["Changer"])
        if each.element == "Locking -> Locked, assignment" and each.new == "(NONE + 1)"
    )
    assert judge(edit, Baseline(network, constants, EXECUTED)).caught_by == ("changer-told",)
    queries = tuple(each for each in network.document.queries if "[changer-told]" not in each.comment)
    fewer = replace(network.document, queries=queries)
    baseline = Baseline(make_network(fewer, constants), constants, EXECUTED)
    edited = replace(edit, document=replace(edit.document, queries=queries))
    assert judge(edited, baseline).outcome == MutantOutcome.SURVIVES


def test_an_edit_that_changes_nothing_is_equivalent(tool) -> None:  # type: ignore[no-untyped-def]
    """At ``Clearing`` the next actuator has the same time-out, unless the description says otherwise."""
    network, constants = load_automata(tool), model_constants(tool)
    edit = next(
        each
        for each in mutants(network.document, ["Gripper"])
        if each.element == "invariant of Clearing" and each.new == "(last + 1)"
    )
    assert judge(edit, Baseline(network, constants, EXECUTED)).outcome == MutantOutcome.EQUIVALENT
    constants |= {"T_GONE": [2000, 1500, 2000]}
    other = Baseline(make_network(network.document, constants), constants, EXECUTED)
    assert judge(edit, other).outcome != MutantOutcome.EQUIVALENT


def test_an_edit_that_switches_an_edge_on_is_judged(tool) -> None:  # type: ignore[no-untyped-def]
    network, constants = load_automata(tool), model_constants(tool)
    edit = next(
        each
        for each in mutants(network.document, ["Gripper"])
        if each.element == "Step -> Step, guard" and each.new == "true"
    )
    assert judge(edit, Baseline(network, constants, EXECUTED)).outcome == MutantOutcome.CAUGHT


def test_a_file_that_fails_itself_judges_nothing(tool) -> None:  # type: ignore[no-untyped-def]
    network, constants = load_automata(tool), model_constants(tool) | {"GRIP_BOUND": 1}
    with pytest.raises(UsageError, match="Does not hold of the file as it is"):
        Baseline(make_network(network.document, constants), constants, EXECUTED)
