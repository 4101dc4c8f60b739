"""Why a run refutes a query, in words, and what the query speaks of."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import HealthCheck, given, settings

from end_effector_hal.description import SHIPPED_AUTOMATA
from tests.support.nightly import PHASES, examples
from tests.unit.timed_automata.explore.models import document
from tests.unit.timed_automata.explore.random_networks import Condition, conditions, networks
from timed_automata import Network, load_network, make_network, read_document
from timed_automata.explain import Explanation, Names, WatchedClock, WatchedState, explain, explain_time
from timed_automata.explore import Explorer
from timed_automata.queries import parse_query

DECLARED = """
const int N = 2;
const int OFF = 0, PENDING = 1, ON = 2;
const int LATE = 5;
int[0, 2] mode[N];
bool valve[N];
int[0, 2] last = OFF;
clock x;
bool quiet() { return forall (j : int[0, 1]) mode[j] == OFF; }
"""
P = """P: own: int[0, 1] i; | Idle: x <= 3 | Busy: x <= 9
    Idle -> Busy; guard: x >= 2; do: mode[i] = PENDING, valve[i] = true
    Busy -> Done; guard: x >= 7; do: mode[i] = ON, last = ON, i = 1"""


def refuted(query: str, *templates: str, declared: str = DECLARED) -> Explanation:
    network = make_network(read_document(document(declared, *(templates or (P,))), "p.xml"))
    verdict = Explorer(network).check(query)
    assert verdict.trace is not None
    assert not verdict.holds
    return explain(verdict.trace, parse_query(query), Names(network, ("cups", "rod"), "mode"))


@pytest.mark.parametrize(
    ("query", "sentence"),
    [
        ("A[] P.Busy imply x <= LATE", "At 6 ms P is in Busy: then x must be at most LATE (5 ms), but it is 6 ms."),
        (
            "A[] P.Idle || x < 2",
            "At 2 ms: one of these must hold: P is in Idle or x is less than 2 ms; but P is "
            "not in Idle (but in Busy) and x is 2 ms (at least 2 ms).",
        ),
        ("A[] mode[0] != ON", "At 7 ms: mode[cups] must not be ON, but it is."),
        ("A[] mode[P.i] == OFF", "At 2 ms: mode[cups] must be OFF, but it is PENDING."),
        ("A[] P.i == 0", "At 7 ms: P.i must be cups (0), but it is rod (1)."),
        ("A[] !P.Done", "At 7 ms: P must not be in Done, but it is."),
        ("A[] forall (j : int[0, 1]) !valve[j]", "At 2 ms: valve[cups] must be false, but it is true."),
        (
            "A[] forall (j : int[0, 1]) j >= P.i || valve[1]",
            "At 7 ms P.i is rod (1): then valve[rod] must be true, but it is false.",
        ),
        (
            "A[] P.Done imply last == OFF && mode[1] == ON",
            "At 7 ms P is in Done: then last must be OFF, but it is ON; mode[rod] must be ON, but it is OFF.",
        ),
        ("A[] quiet()", "At 2 ms: quiet() must hold, but mode[cups] is PENDING."),
        (
            "A[] !(P.Busy && valve[0])",
            "At 2 ms: these must not all hold together: P is in Busy and valve[cups] is true.",
        ),
        (
            "A[] valve[0] == (mode[0] == ON)",
            "At 2 ms: valve[cups] == (mode[cups] == ON) must hold, but it does not "
            "(valve[cups] is true and mode[cups] is PENDING).",
        ),
        ("A[] !(exists (j : int[0, 1]) mode[j] == ON)", "At 7 ms: mode[cups] must not be ON, but it is."),
    ],
)  # fmt: skip
def test_the_sentence(query: str, sentence: str) -> None:
    assert refuted(query).sentence == sentence


def test_what_never_comes_is_due_since_its_condition_held() -> None:
    found = refuted("P.Busy --> P.Idle")
    assert found.sentence == (
        "At 2 ms P is in Busy; from there on this must come: P.Idle. It never does: at 7 ms P must be in Idle, but it "
        "is in Done, and from here time can pass without end."
    )
    assert refuted("A<> P.Done && x < 5").sentence.startswith(
        "From the start on this must come: P.Done && x < 5."
    )


def test_what_it_speaks_of_is_shown_over_the_run() -> None:
    busy, clock = refuted("A[] P.Busy imply x <= LATE").watched
    assert busy == WatchedState("P", ((Fraction(0), "Idle"), (Fraction(2), "Busy")), wrong=False)
    assert isinstance(clock, WatchedClock)
    assert (clock.name, clock.limits, clock.deadline, clock.wrong) == ("x", (("<= LATE (5 ms)", 5),), 5, True)
    assert clock.points == ((0, 0), (2, 2), (6, 6))


def test_only_what_is_not_as_it_must_be_is_wrong() -> None:
    found = refuted("A[] P.Busy imply quiet() || mode[P.i] == ON")
    assert [(each.name, each.wrong) for each in found.watched] == [
        ("P", False),
        ("mode[cups]", True),
        ("mode[rod]", False),
        ("P.i", False),
    ]
    assert found.watched[1] == WatchedState(
        "mode[cups]", ((Fraction(0), "OFF"), (Fraction(2), "PENDING")), wrong=True
    )


def test_a_lower_bound_has_no_deadline() -> None:
    (_, clock) = refuted("A[] P.Done imply x >= 8").watched
    assert isinstance(clock, WatchedClock)
    assert (clock.limits, clock.deadline, clock.wrong) == ((((">= 8 ms"), 8),), None, True)


def test_a_clock_that_was_set_has_its_deadline_since_then() -> None:
    again = "P: a: x <= 2 | a -> b; guard: x >= 2; do: x = 1"
    (_, clock) = refuted("A[] P.b imply x <= 4", again, declared="clock x;").watched
    assert isinstance(clock, WatchedClock)
    assert clock.deadline == 5
    assert clock.points == ((0, 0), (2, 2), (2, 1), (6, 5))


def test_a_deadlock_says_who_may_not_stay() -> None:
    stuck = "P: a: x <= 3 | b: x <= 8 | a -> b; guard: x >= 2 | b -> a; guard: x >= 9"
    found = refuted("A[] not deadlock", stuck, declared="clock x;")
    assert found.sentence.startswith(
        "At 2 ms: a transition must be possible, but none is. P may not stay in b beyond x <= 8 ms"
    )
    assert [each.name for each in found.watched] == ["P", "x"]


def test_a_timelock_and_a_cycle_without_time_are_explained() -> None:
    stuck = "P: b: x <= 8 | a -> b; guard: x >= 2"
    network = make_network(read_document(document("clock x;", stuck), "p.xml"))
    trace = Explorer(network).timelock().trace
    assert trace is not None
    assert "P may not stay in b beyond x <= 8 ms" in explain_time(trace, Names(network)).sentence
    hasty = make_network(read_document(document("", "Q: a -> b | b -> a"), "q.xml"))
    trace = Explorer(hasty).zeno().trace
    assert trace is not None
    found = explain_time(trace, Names(hasty))
    assert found.sentence == "At 0 ms this can go on for ever while no time passes. Q a → b and Q b → a."
    assert [each.name for each in found.watched] == ["Q"]


def test_an_index_beyond_the_array_that_is_never_used_is_no_fault() -> None:
    found = refuted("A[] forall (j : int[0, 4]) j < 2 imply mode[j] == OFF")
    assert found.sentence == "At 2 ms: mode[cups] must be OFF, but it is PENDING."


@pytest.mark.parametrize("query", ["A[] f()", "A<> f()", "x == 0 --> f()", "A[] x == 2 imply f()"])
def test_a_function_of_constants_alone_costs_no_verdict(query: str) -> None:
    found = refuted(
        query,
        "P: a: x <= 3 | a -> a; guard: x >= 2; do: x = 0",
        declared="clock x; const int C = 0; bool f() { return C == 1; }",
    )
    assert "f()" in found.sentence


def test_a_function_of_a_process_is_not_the_global_one_of_its_name() -> None:
    own = P.replace("i;", "i; bool quiet() { return i == 0; }", 1)
    found = refuted("A[] P.quiet()", own)
    assert found.sentence == "At 7 ms: P.quiet() must hold, but it does not."
    assert [(each.name, each.wrong) for each in found.watched] == [("P.i", True)]


# Constants and members instead of integers: by how the file itself uses them, never by chance.


CUPS = ("cups", "rod", "cap")


@pytest.fixture(scope="module")
def shipped() -> Names:
    network = load_network(SHIPPED_AUTOMATA)
    return Names(network, CUPS, "actuator", ("cause_at",))


@pytest.mark.parametrize(
    ("variable", "value", "word"),
    [
        ("ee", 3, "GRIPPED"),
        ("ee", 0, "OFF"),
        ("command", -1, "NONE"),
        ("command", 2, "GRIP"),
        ("watched", 4, "CANCEL"),
        ("actuator[1]", 1, "PENDING"),
        ("evidence[0]", 0, "UNKNOWN"),
        ("evidence[2]", 3, "CONFIRMED"),
        ("tool", 1, "LOCKED"),
        ("changer", 3, "UNLOCKING"),
        ("changer", 0, "0"),  # it has constants of two groups: UNCLEAR, of the first, is no value of it
        ("cause", 1, "TIMED_OUT"),
        ("world", 4, "IN_TIME"),
        ("valve[0]", 1, "true"),
        ("Gripper.i", 1, "rod (1)"),
        ("Gripper.i", 3, "3"),
        ("Gripper.k", 1, "1"),  # a place in the release order, no actuator
        ("Gripper.attempt", 2, "2"),
        ("cause_at", 2, "cap (2)"),
        ("cause_at", -1, "-1"),
        ("culprit", 0, "cups (0)"),
    ],
)
def test_values_of_the_shipped_tool(shipped: Names, variable: str, value: int, word: str) -> None:
    assert shipped.value(variable, value) == word


@pytest.mark.parametrize(
    ("name", "word"),
    [
        ("evidence[1]", "evidence[rod]"),
        ("Actuator(2)", "Actuator(cap)"),
        ("Wills.spared[0]", "Wills.spared[cups]"),
        ("deactivate[0]", "deactivate[cups]"),
        ("told[1]", "told[1]"),
        ("tool_is[1]", "tool_is[1]"),
        ("Gripper.i", "Gripper.i"),
        ("Gripper", "Gripper"),
    ],
)
def test_elements_of_the_shipped_tool(shipped: Names, name: str, word: str) -> None:
    assert shipped.element(name) == word


def test_a_quantified_name_is_not_that_of_a_variable() -> None:
    declared = "const int A = 0, B = 1; int a[2]; int[0, 1] j; bool all() { return forall (j : int[0, 1]) a[j] == B; }"
    network = make_network(read_document(document(declared, "P: u -> v"), "p.xml"))
    names = Names(network, ("x", "y"), "a")
    assert names.value("j", 1) == "1"
    assert names.value("a[0]", 0) == "A"
    assert names.element("a[1]") == "a[y]"


# Whatever the network and the query: a run that refutes it has its explanation, which fits the run.


many = settings(
    max_examples=examples(20, 2000), deadline=None, suppress_health_check=list(HealthCheck), phases=PHASES
)


@many
@given(networks(), conditions(), conditions(1))
def test_what_refutes_is_explained(network: Network, p: Condition, q: Condition) -> None:
    for text in (
        f"A[] !({p})",
        f"A[] ({p}) imply {q}",
        f"A[] !deadlock || ({p})",
        f"A<> {p}",
        f"{p} --> {q}",
    ):
        trace = Explorer(network).check(text).trace
        if trace is None:
            continue
        found = explain(trace, parse_query(text), Names(network))
        assert found.sentence.endswith(".")
        assert any(each.wrong for each in found.watched)
        state = trace.steps[-1].state if trace.steps else network.initial
        shown = {
            process.name: process.locations[state.locations[process.index]].name
            for process in network.processes
        }
        shown["i"] = str(state.values[network.offset("i")])
        for each in found.watched:
            if isinstance(each, WatchedClock):
                assert each.points[-1][0] == trace.end
                assert all(
                    before[0] <= after[0] for before, after in zip(each.points, each.points[1:], strict=False)
                )
            else:
                assert each.changes[-1][1] == shown[each.name]
