"""Systematic mutants of the shipped automata: a requirement notices each that is not proven to change nothing."""

from __future__ import annotations

from dataclasses import replace
from random import Random

import pytest

from end_effector_hal.control import load_automata, model_constants
from end_effector_hal.errors import UsageError
from tests.support.nightly import NIGHTLY, first_of
from timed_automata import make_network
from tools.mutants import Baseline, Baselines, MutantOutcome, judge, judge_all, mutants

EXECUTED = ("Gripper", "Actuator", "Changer", "Arming")
SAMPLE, SEED = 300 if NIGHTLY else 30, 2026
PARTS = 1 if NIGHTLY else 3


@pytest.fixture(scope="module")
def baselines(verdin) -> Baselines:  # type: ignore[no-untyped-def]
    return Baselines(load_automata(verdin), model_constants(verdin), EXECUTED)


@pytest.fixture(scope="module")
def shipped(verdin) -> Baseline:  # type: ignore[no-untyped-def]
    return Baseline(load_automata(verdin), model_constants(verdin), EXECUTED)


@pytest.mark.timeout(7200)
@pytest.mark.parametrize("part", first_of(range(PARTS)))
def test_a_requirement_notices_each_edit(verdin, baselines, part: int) -> None:  # type: ignore[no-untyped-def]
    """An ordinary run leaves out what the shipped tool switches off: it is judged at night, with other tools."""
    network, constants = load_automata(verdin), model_constants(verdin)
    if NIGHTLY:
        found = list(judge_all(network, constants, EXECUTED, sample=SAMPLE, seed=SEED))
    else:
        quickest = next(iter(baselines))
        drawn = Random(SEED).sample(list(mutants(network.document, EXECUTED, constants)), SAMPLE)[part::PARTS]
        found = [judge(each, quickest) for each in drawn]
        unnoticed = [each for each in found if each.outcome == MutantOutcome.SURVIVES]
        found += [baselines.judge(each.mutant) for each in unnoticed]
        found = [each for each in found if each not in unnoticed]
    open_ = (MutantOutcome.SURVIVES, MutantOutcome.OPEN)
    assert [str(each.mutant) for each in found if each.outcome in open_] == []
    caught = [each for each in found if each.outcome == MutantOutcome.CAUGHT]
    # the others: switched off by the constants, or no model
    assert len(caught) > (0.9 if NIGHTLY else 0.5) * SAMPLE / PARTS


@pytest.mark.thinned  # long
def test_a_requirement_that_is_taken_away_lets_its_mutant_live(verdin, shipped) -> None:  # type: ignore[no-untyped-def]
    """The judge says that nothing notices where nothing does."""
    network, constants = load_automata(verdin), model_constants(verdin)
    edit = next(
        each
        for each in mutants(network.document, ["Changer"])
        if each.element == "Locking -> Locked, assignment" and each.new == "(NONE + 1)"
    )
    assert judge(edit, shipped).caught_by == ("changer-told",)
    queries = tuple(each for each in network.document.queries if "[changer-told]" not in each.comment)
    fewer = replace(network.document, queries=queries)
    baseline = Baseline(make_network(fewer, constants), constants, EXECUTED)
    edited = replace(edit, document=replace(edit.document, queries=queries))
    assert judge(edited, baseline).outcome == MutantOutcome.SURVIVES


@pytest.mark.thinned  # long
def test_an_edit_that_changes_nothing_is_equivalent(verdin, shipped) -> None:  # type: ignore[no-untyped-def]
    """At ``Clearing`` the next actuator has the same time-out, unless the description says otherwise."""
    network, constants = load_automata(verdin), model_constants(verdin)
    edit = next(
        each
        for each in mutants(network.document, ["Gripper"])
        if each.element == "invariant of Clearing" and each.new == "(last + 1)"
    )
    assert judge(edit, shipped).outcome == MutantOutcome.EQUIVALENT
    constants |= {"T_GONE": [2000, 1500, 2000]}
    other = Baseline(make_network(network.document, constants), constants, EXECUTED)
    assert judge(edit, other).outcome != MutantOutcome.EQUIVALENT


@pytest.mark.parametrize(
    ("template", "element", "new"),
    [
        ("Gripper", "function now", "(k)"),  # it is asked only with k < N
        (
            "Changer",
            "location Opening",
            "ordinary",
        ),  # the environment asks in a committed location: nothing comes between
    ],
)
def test_an_edit_that_makes_no_difference_is_no_survivor(  # type: ignore[no-untyped-def]
    verdin, baselines, template: str, element: str, new: str
) -> None:
    document = load_automata(verdin).document
    (edit,) = (each for each in mutants(document, [template]) if (each.element, each.new) == (element, new))
    assert judge(edit, next(iter(baselines))).outcome == MutantOutcome.EQUIVALENT


@pytest.mark.thinned  # long
def test_an_edit_that_switches_an_edge_on_is_judged(shipped) -> None:  # type: ignore[no-untyped-def]
    edit = next(
        each
        for each in mutants(shipped.network.document, ["Gripper"])
        if each.element == "Step -> Step, guard" and each.new == "true"
    )
    assert judge(edit, shipped).outcome == MutantOutcome.CAUGHT


@pytest.mark.parametrize(
    ("template", "element", "new", "by"),
    [
        ("Gripper", "Step -> Reset, assignment", "1", ("second-attempt", "one step")),
        pytest.param(
            "Gripper", "Abort -> Unwind, assignment", "1", ("forgotten", "one step"), marks=pytest.mark.thinned
        ),
        pytest.param(
            "Arming",
            "Armed -> Idle, guard",
            "(T_ARM - 1)",
            ("arm-stays", "no sensors of the stand"),
            marks=pytest.mark.thinned,
        ),
    ],
)  # fmt: skip
def test_what_one_tool_switches_off_is_judged_with_another(  # type: ignore[no-untyped-def]
    verdin, baselines, template: str, element: str, new: str, by: tuple[str, str]
) -> None:
    document = load_automata(verdin).document
    edit = next(
        each
        for each in mutants(document, [template])
        if each.element == element and each.operator == "constant" and each.new == new
    )
    verdict = baselines.judge(edit)
    assert by[0] in verdict.caught_by
    assert verdict.variant == by[1]


ONCE_UNNOTICED = [
    ("Empty -> Reset, assignment: constant, '0' -> '1'", "second-attempt", "one step, evidence of nothing"),
    ("Step -> Step: target, 'Step -> Step' -> 'Step -> Decide'", "order-step", "an ending holds one of two"),
    ("changer == 0 && ...' -> 'IL_02 && !STAND'", "arm-refused", "no sensors of the stand"),
    ("Armed -> Idle: edge deleted", "armed", "no sensors of the stand"),
    ("Blown: urgent", "blow-whole", "one is blown off, a cancel holds the other"),
    (
        "Check -> Unwind, guard: condition dropped, 'evidence[now()] == GONE && !blows()'",
        "blow-due",
        "one step, blown off",
    ),
    ("Empty -> Abort, assignment: constant, 'EMPTY'", "cause-at", "one step, evidence of nothing, no tool changer"),
    ("'Gap -> Check' -> 'Gap -> Rest'", "blow-needed", "one is blown off, a cancel holds the other"),
    ("needless: condition dropped, 'UNTIL_GONE[now()] && ", "blow-needed", "both are blown off"),
    ("Blown -> Rest, assignment: constant, '0' -> '1'", "blow-gap", "one step, blown off"),
    ("Gap -> Check, assignment: assignment dropped", "time", "one step, blown off"),
    ("function ready: condition dropped, '(!IL_07 || clear()) && fastened() &&", "accepted", "one step"),
    ("function ready: condition dropped, '!IL_06 || supply_ok' -> 'supply_ok'", "refused-for", "one step, no IL-06"),
    (
        "liftable, which no template calls: condition dropped, 'ee == GRIPPED && firm() && fastened()'",
        "lift",
        "one step",
    ),
    (
        "function fastened: condition dropped, '!PRESENCE || tool != ABSENT' -> '!PRESENCE'",
        "lift-allowed",
        "only the presence of the tool is shown",
    ),
    (
        "Gap -> Blowing, assignment: assignment dropped, 'blow[now()] = true, t = 0' -> 'b",
        "blow-whole",
        "one step, blown off",
    ),
    (
        "Gap -> Blowing, assignment: assignment dropped, 'blow[now()] = true, t = 0' -> 't",
        "blow-alone",
        "one step, blown off",
    ),
    (
        "Gripped -> Abort, assignment: constant, 'j' -> '(j - 1)'",
        "cause-at",
        "one step, a loss and the start release it",
    ),
    ("function found_part: constant, '0' -> '1'", "part-found", "two parts"),
    ("Off -> GripError, assignment: assignment dropped, 'ee = GRIP_ERROR, part", "part-found", "two parts"),
    ("TIMEOUT_KEEPS[n]) && TIMEOUT_KEEPS[i...' -> 't >=", "second-attempt", "one step"),
    ("Blowing -> Blown, guard: negation, 'BLOWS' -> '!BLOWS'", "blow-refused", "one step, blown off"),
    ("command = RELEASE, asked = true, homes = 2, t = 0, end_grip", "drops-all", "one step"),
    ("StandBy -> Unwind, guard: condition dropped, '!clear()' -> 'true'", "drops-all", "one step"),
    ("StandBy -> Unwind, synchronisation: synchronisation, 'drop' -> 'resume'", "drops", "one step"),
    ("'changer == 0 && tool == ABSENT' -> 'changer == 0'", "arm-refused", "no sensors of the stand"),
]  # fmt: skip
"""Edits that no requirement noticed before: words of them, which one does today, and of which tool it is asked."""


@pytest.mark.parametrize(
    "case", first_of(sorted(ONCE_UNNOTICED, key=lambda each: each[1] != "armed"), 0, 2), ids=lambda each: each[1]
)  # fmt: skip
def test_what_was_not_noticed_once(verdin, baselines, case: tuple[str, str, str]) -> None:  # type: ignore[no-untyped-def]
    words, by, variant = case
    baseline = next(each for each in baselines if each.variant == variant)
    given = model_constants(verdin)
    edits = [each for each in mutants(load_automata(verdin).document, EXECUTED, given) if words in str(each)]
    assert by in {id_ for each in edits for id_ in judge(each, baseline).caught_by}


@pytest.mark.thinned  # long
def test_a_file_that_fails_itself_judges_nothing(verdin) -> None:  # type: ignore[no-untyped-def]
    network, constants = load_automata(verdin), model_constants(verdin) | {"GRIP_BOUND": 1}
    with pytest.raises(UsageError, match="Does not hold of the file as it is"):
        Baseline(make_network(network.document, constants), constants, EXECUTED)
