"""Why a run refutes a query, in words, and what the query speaks of."""

from __future__ import annotations

from fractions import Fraction

import pytest

from tests.unit.timed_automata.explore.models import Template, document
from timed_automata import make_network, read_document
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
P = Template(
    "P",
    [
        "Idle -> Busy; guard: x >= 2; do: mode[i] = PENDING, valve[i] = true",
        "Busy -> Done; guard: x >= 7; do: mode[i] = ON, last = ON, i = 1",
    ],
    declarations="int[0, 1] i;",
    invariants={"Idle": "x <= 3", "Busy": "x <= 9"},
)


def refuted(query: str, *templates: Template, declared: str = DECLARED) -> Explanation:
    network = make_network(read_document(document(declared, *(templates or (P,))), "p.xml"))
    verdict = Explorer(network).check(query)
    assert verdict.trace is not None
    assert not verdict.holds
    return explain(verdict.trace, parse_query(query), Names(network, ("cups", "rod"), "mode"))


@pytest.mark.parametrize(
    ("query", "sentence"),
    [
        (
            "A[] P.Busy imply x <= LATE",
            "At 6 ms P is in Busy: then x must be at most LATE (5 ms), but it is 6 ms.",
        ),
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
)
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
    again = Template("P", ["a -> b; guard: x >= 2; do: x = 1"], invariants={"a": "x <= 2"})
    (_, clock) = refuted("A[] P.b imply x <= 4", again, declared="clock x;").watched
    assert isinstance(clock, WatchedClock)
    assert clock.deadline == 5
    assert clock.points == ((0, 0), (2, 2), (2, 1), (6, 5))


def test_a_deadlock_says_who_may_not_stay() -> None:
    stuck = Template(
        "P", ["a -> b; guard: x >= 2", "b -> a; guard: x >= 9"], invariants={"a": "x <= 3", "b": "x <= 8"}
    )
    found = refuted("A[] not deadlock", stuck, declared="clock x;")
    assert found.sentence.startswith(
        "At 2 ms: a transition must be possible, but none is. P may not stay in b beyond x <= 8 ms"
    )
    assert [each.name for each in found.watched] == ["P", "x"]


def test_a_timelock_and_a_cycle_without_time_are_explained() -> None:
    stuck = Template("P", ["a -> b; guard: x >= 2"], invariants={"b": "x <= 8"})
    network = make_network(read_document(document("clock x;", stuck), "p.xml"))
    trace = Explorer(network).timelock().trace
    assert trace is not None
    assert "P may not stay in b beyond x <= 8 ms" in explain_time(trace, Names(network)).sentence
    hasty = make_network(read_document(document("", Template("Q", ["a -> b", "b -> a"])), "q.xml"))
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
        Template("P", ["a -> a; guard: x >= 2; do: x = 0"], invariants={"a": "x <= 3"}),
        declared="clock x; const int C = 0; bool f() { return C == 1; }",
    )
    assert "f()" in found.sentence


def test_a_function_of_a_process_is_not_the_global_one_of_its_name() -> None:
    own = Template("P", P.edges, declarations="int[0, 1] i; bool quiet() { return i == 0; }")
    found = refuted("A[] P.quiet()", own)
    assert found.sentence == "At 7 ms: P.quiet() must hold, but it does not."
    assert [(each.name, each.wrong) for each in found.watched] == [("P.i", True)]
