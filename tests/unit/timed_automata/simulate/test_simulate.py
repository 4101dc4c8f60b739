"""Runs by chance and by choice: always runs of the network, in exact time, the same for the same numbers."""

from __future__ import annotations

import re
from fractions import Fraction
from random import Random

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from end_effector_hal.description import SHIPPED_AUTOMATA
from end_effector_hal.errors import ModelError, RangeError, UsageError
from tests.support.nightly import examples, first_of
from tests.unit.timed_automata.explore.models import network
from tests.unit.timed_automata.explore.random_networks import networks
from tests.unit.timed_automata.simulate.run_facts import assert_is_run
from timed_automata import load_network
from timed_automata.simulate import Machine, parse_choices, simulate

WINDOW = "P: a: x < 5 | a -> b; guard: x >= 2; do: x = 0 | b -> a; guard: x > 1"


class Least:
    """Always chooses the first: the earliest instant of the first transition."""

    def randrange(self, stop):
        return 0


class Most:
    """Always chooses the last."""

    def randrange(self, stop):
        return stop - 1


def window():
    return network("clock x;", WINDOW)


def times(run):
    return [step.at for step in run.trace.steps]


@pytest.fixture(scope="module")
def shipped():
    return load_network(SHIPPED_AUTOMATA)


# By chance ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", first_of(range(40), 5, 10))
def test_random_runs_of_the_shipped_model_are_runs_of_it(shipped, seed):
    run = simulate(shipped, Random(seed), steps=300)
    assert run.error is None
    assert len(run.trace.steps) == 300
    assert_is_run(run.trace)


@settings(max_examples=examples(25, 2000), deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(model=networks(), seed=st.integers(0, 1 << 32))
def test_random_runs_of_random_models_are_runs_of_them(model, seed):
    try:
        run = simulate(model, Random(seed), steps=40)
    except ModelError as error:
        assert "initial state" in error.what  # noqa: PT017 - some random models have no run at all
    else:
        assert_is_run(run.trace)


def test_the_same_seed_is_the_same_run(shipped):
    first, again = (simulate(shipped, Random(3), steps=80).trace.lines for _ in range(2))
    assert first == again
    assert first != simulate(shipped, Random(4), steps=80).trace.lines


def test_instants_reach_both_ends_of_what_strict_bounds_allow():
    # a: 2 <= x < 5; b: x > 1. The finest time is a microsecond.
    assert times(simulate(window(), Least(), steps=2)) == [2, 2 + Fraction(1001, 1000)]
    assert times(simulate(window(), Most(), steps=1)) == [Fraction(4999, 1000)]


def test_without_a_limit_an_instant_is_spread_over_two_seconds():
    model = network("clock x;", "P: a -> b; guard: x >= 3")
    assert times(simulate(model, Most(), steps=1)) == [2003]


def test_every_drawn_edge_is_as_likely_as_any_other():
    model = network(
        "int[0,9] v;",
        "P: urgent: a | a -> b; select: n : int[0,9]; do: v = n | a -> c",
    )
    ends = [simulate(model, Random(seed), steps=1).trace.steps[0].state.locations[0] for seed in range(400)]
    assert 150 < ends.count(2) < 250  # location c; not one in eleven
    values = {simulate(model, Random(seed), steps=1).trace.steps[0].state.values[0] for seed in range(400)}
    assert values == set(range(10))


# The end -----------------------------------------------------------------------------------------------------


def test_a_hundred_steps_unless_told_otherwise(shipped):
    assert len(simulate(shipped, Random(0)).trace.steps) == 100
    assert simulate(shipped, Random(0), steps=0).trace.steps == ()


def test_a_run_of_a_length_ends_there_between_transitions(shipped):
    trace = simulate(shipped, Random(3), until=7_000_000).trace
    assert trace.end == 7000
    assert 6000 < trace.steps[-1].at <= 7000
    assert (
        simulate(shipped, Random(3), until=3_000_000).trace.lines[:-1]
        == trace.lines[: len(simulate(shipped, Random(3), until=3_000_000).trace.steps)]
    )


def test_nothing_more_can_happen():
    trace = simulate(network("clock x;", "P: a -> b; guard: x >= 3"), Least()).trace
    assert (trace.end, trace.remark) == (3, "Nothing can happen any more; time goes on.")
    longer = simulate(network("clock x;", "P: a -> b"), Least(), until=9_000_000).trace
    assert longer.end == 9000


@pytest.mark.parametrize(
    ("template", "remark"),
    [
        (
            "P: b: x <= 7 | a -> b",
            "Deadlock: nothing can happen, and time may not pass beyond 7 ms.",
        ),
        ("P: committed: b | a -> b", "Deadlock: nothing can happen, and time may not pass."),
        ("P: urgent: b | a -> b", "Deadlock: nothing can happen, and time may not pass."),
        ("P: urgent: a | a -> a", "No end after 1000 transitions at this instant: time does not pass."),
    ],
)  # fmt: skip
def test_how_a_run_can_get_stuck(template, remark):
    assert simulate(network("clock x;", template), Least(), until=60_000_000).trace.remark == remark


def test_an_invariant_that_a_transition_would_violate_forbids_it():
    model = network(
        "clock x, y;",
        "P: b: y <= 4 | c: x < 9 | a -> b | a -> c; do: x = 9",
    )
    (option,) = Machine(model).options()
    assert (option.first, option.last) == (0, 4000)


def test_so_does_an_invariant_about_data():
    (option,) = Machine(network("int v;", "P: b: v < 2 | a -> b; do: v = 1 | a -> b; do: v = 2")).options()
    assert option.fired.state.values == (1,)


def test_a_value_out_of_range_ends_the_run_with_its_place():
    model = network("clock x; int[0,2] v;", "P: a -> a; guard: x >= 1; do: v++, x = 0")
    run = simulate(model, Least())
    assert times(run) == [1, 2]
    assert isinstance(run.error, RangeError)
    assert run.error.where.startswith("model.xml:1:")
    assert run.trace.end == 3
    assert run.trace.remark == run.error.what


def test_no_run_begins_in_a_violated_invariant():
    model = network("int v = 1;", "P: a: v == 0 | a -> b")
    with pytest.raises(ModelError, match="The initial state violates an invariant") as error:
        simulate(model, Least())
    assert error.value.where == "model.xml"


# By choice ---------------------------------------------------------------------------------------------------

ABORT = """world == NEVER && culprit == 1; adopt; grip @ 1000; confirmed[0] + 350; Gripper.Reset; Gripper.Activate;
    Gripper.Reset; Gripper.Activate @ 13360.5; ee == GRIP_ERROR; gone[0] + 300"""


def test_the_third_scenario_of_the_paper_by_choice(shipped):
    trace = simulate(shipped, Random(9), parse_choices(shipped, ABORT)).trace
    assert_is_run(trace)
    entered = {
        shipped.processes[0].locations[edge.target].name: step.at
        for step in trace.steps
        for edge in step.edges
        if edge.process == 0
    }
    # the second Reset is entered at 12350, which leaves 1000 to 1050 for the reset
    assert {name: entered[name] for name in ("Reset", "Abort", "Releasing", "StandBy")} == {
        "Reset": 12350,
        "Abort": Fraction(183605, 10),
        "Releasing": Fraction(183605, 10),
        "StandBy": Fraction(186605, 10),
    }
    assert trace.steps[-1].state.values[shipped.offset("ee")] == 6
    # what cannot wait after the last choice is taken, and nothing else
    assert trace.end == trace.steps[-1].at == Fraction(186605, 10)


def test_after_the_choices_the_run_goes_on_by_chance(shipped):
    choices = parse_choices(shipped, "world == IN_TIME; adopt")
    assert len(simulate(shipped, Random(1), choices, steps=50).trace.steps) == 50
    assert simulate(shipped, Random(1), choices, until=20_000_000).trace.end == 20_000
    # the end comes first
    assert len(simulate(shipped, Random(1), choices, steps=2).trace.steps) == 2
    late = parse_choices(shipped, "world == IN_TIME; adopt; grip @ 5000")
    assert simulate(shipped, Random(1), late, until=4_000_000).trace.end == 4000


def test_a_choice_says_where_and_when():
    model = network(
        "broadcast chan c[2]; clock x; int v;",
        "P: a -> b; guard: x >= 2; sync: c[1]! | b -> a; guard: x >= 4; do: v = 1 - v",
    )
    run = simulate(
        model, Least(), parse_choices(model, " c[ 1 ] + 2.5 ms ;; v == 1; c[1]; v == 0 && P.a @7;")
    )
    assert times(run) == [Fraction(5, 2), 4, 4, 7]


def test_a_condition_chooses_what_makes_it_true_not_what_leaves_it_so():
    model = network("int v;", "P: a -> a; do: v = 1 - v", "Q: a -> b | b -> a")
    run = simulate(model, Most(), parse_choices(model, "Q.b; v == 1; Q.a && v == 1"))
    assert [step.edges[0].process for step in run.trace.steps] == [1, 0, 1]
    already = parse_choices(model, "P.a")
    with pytest.raises(UsageError, match=r"'P\.a', is not possible"):
        simulate(model, Least(), already)


@pytest.mark.parametrize(
    ("choices", "message"),
    [
        ("c[1] @ 1", "Choice 1, 'c[1] @ 1', is not possible after 0 steps, at 0 ms: it is possible from 2 ms to 9 ms."),
        ("c[1]; P.b", "Choice 2, 'P.b', is not possible after 1 steps, at 2 ms. Possible: P.a (from 4 ms to 9 ms)."),
        ("c[1]; P.a @ 10", "it is possible from 4 ms to 9 ms"),
        ("c[0]", "Choice 1, 'c[0]', is not possible after 0 steps, at 0 ms. Possible: c[1] (from 2 ms to 9 ms)."),
        ("c[1] @ 10000000000.001", "The time in 'c[1] @ 10000000000.001' is too long. A run has at most"),
        (f"c[1] + {'9' * 6000}", "is too long. A run has at most 10000000000 ms."),
        ("c[1] @ 2.0005", "The time in 'c[1] @ 2.0005' is finer than a microsecond."),
        ("@ 3", "'@ 3' has a time and no choice."),
        ("c[1] @ soon", "'c[1] @ soon' does not end with a time in ms."),
        ("x > 3", "'x > 3' names a clock."),
        ("deadlock", "'deadlock' names a clock."),
    ],
)  # fmt: skip
def test_a_choice_that_cannot_be_met(choices, message):
    model = network(
        "broadcast chan c[2]; clock x; int v;",
        "P: b: x <= 9 | a -> b; guard: x >= 2; sync: c[1]! | b -> a; guard: x >= 4",
    )
    with pytest.raises(UsageError, match=re.escape(message)):
        simulate(model, Least(), parse_choices(model, choices))


@pytest.mark.parametrize(
    ("choices", "message"),
    [
        ("grab", "'grab' is not declared"),
        ("Gripper.Stepz", "no location and no variable 'Stepz'. Did you mean 'Step'?"),
        ("ee = 3", "choice:1:1: 'ee = 3', an assignment inside an expression"),
        ("confirmed[7]", "choice:1:"),
    ],
)
def test_a_choice_that_is_no_condition(shipped, choices, message):
    with pytest.raises(ModelError, match=re.escape(message)):
        parse_choices(shipped, choices)


def test_what_never_waits_for_a_choice_is_said():
    model = network("int v; broadcast chan c;", "P: urgent: a | a -> a | a -> b; guard: v == 1; sync: c!")
    run = simulate(model, Least(), parse_choices(model, "c"))
    assert run.trace.remark.startswith("No end after 1000 transitions")
