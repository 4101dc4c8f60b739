"""Queries: what is understood, what is refused by name and position, and the runs that answer them."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import pytest

from end_effector_hal.errors import ModelError
from tests.unit.timed_automata.explore.classics import fischer
from tests.unit.timed_automata.explore.models import network
from timed_automata import Network, Trace
from timed_automata.explore import Explorer, Verdict, verify
from timed_automata.queries import parse_query

# Reading queries: what is understood, and what is refused by name and position.


@pytest.fixture(scope="module")
def model() -> Network:
    cell = """Cell(const int[0,3] id): own: clock x; int[0,4] level; int[0,3] pair[2];
        off -> on; guard: x >= id + 1; do: x = 0, level = id + 1, last = id
        on -> off; do: level = 0"""
    return network("int[0,3] last; clock t, u[3]; bool two() { return last == 2; }", cell)


@pytest.fixture(scope="module")
def explorer(model: Network) -> Explorer:
    return Explorer(model)


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("A[] true", "A[]"),
        (" A [ ] true", "A[]"),
        ("E<>true", "E<>"),
        ("A<>\ntrue", "A<>"),
        ("E [] true", "E[]"),
        ("true --> false", "-->"),
        ("sup: t", "sup"),
        ("inf{last == 1}: t, last", "inf"),
    ],
)
def test_kinds(text: str, kind: str) -> None:
    assert parse_query(text).kind == kind
    assert str(parse_query(text)) == " ".join(text.split())


@pytest.mark.parametrize(
    ("condition", "possible"),
    [
        ("Cell(3).on", True),
        ("Cell(3).on && Cell(3).x == 0", True),
        ("Cell(3).on && t < 4", False),
        ("Cell(3).on && 4 > t", False),
        ("Cell(3).on && 4 >= t", True),
        ("exists (i : int[0,3]) Cell(i).on && Cell(i).level == 2", True),
        ("forall (i : int[0,3]) Cell(i).on", True),
        ("exists (i : int[0,3]) Cell(i).on && Cell(i).x > 2 && t < 2", False),
        ("two()", True),
        ("two() and t < 3", False),
        ("two() and not (t < 3)", True),
        ("Cell(0).on imply t < 1", True),
        ("not (Cell(0).on imply t >= 1)", False),
        ("t == 3 && Cell(2).on", True),
        ("t != 3 && Cell(2).on && t <= 3", False),
        ("Cell(2).on ? t < 3 : false", False),
        ("u[1] > 7 && u[last] > 7", True),
        ("Cell(2).pair[1] == 1", False),
        ("Cell(1).id == 1 && last == 1", True),
        ("(sum (i : int[0,3]) Cell(i).level) == 10", True),
        ("deadlock", False),
    ],
)
def test_conditions(explorer: Explorer, condition: str, possible: bool) -> None:
    assert explorer.check(f"E<> {condition}").holds is possible
    assert explorer.check(f"A[] not ({condition})").holds is not possible


@pytest.mark.parametrize(
    ("text", "where", "what"),
    [
        ("Pr[<=10](<> Cell(0).on)", "1:1", "statistical"),
        ("E[<=10; 100](max: t)", "1:1", "statistical"),
        ("simulate [<=10] {t}", "1:1", "statistical"),
        ("strategy s = control: A<> Cell(0).on", "1:1", "strateg"),
        ("control: A[] true", "1:1", "control"),
        ("E<> control: A[] true", "1:1", "control"),
        ("A[ Cell(0).off U Cell(0).on ]", "1:1", "until"),
        ("bounds: t", "1:1", "bounds"),
        ("A[] Cell(0).on --> Cell(0).off", "1:16", "-->"),
        ("Cell(0).on", "1:1", "no query"),
        ("A[] t - u[0] < 3", "1:5", "diagonal"),
        ("A[] t < u[0]", "1:5", "diagonal"),
        ("A[] t + 1 < 3", "1:5", "a clock in an expression"),
        ("A[] t", "1:5", "clock"),
        ("A[] u < 3", "1:5", "array of clocks"),
        ("A[] Cell(0).of", "1:5", "no location and no variable 'of'"),
        ("A[] Cell(10).on", "1:5", "no process 'Cell(10)'"),
        ("A[] Cel(1).on", "1:5", "no process 'Cel(1)'"),
        ("A[] Cell(last).on", "1:10", "must be constant"),
        ("A[] lats == 1", "1:5", "'lats' is not declared"),
        ("A[] last = 1", "1:5", "assignment"),
        ("A[] two", "1:5", "function"),
        ("A[] (deadlock == 1)", "1:6", "'deadlock' in an expression"),
        ("A<> deadlock", "1:5", "'deadlock' outside of A[] and E<>"),
        ("deadlock --> true", "1:1", "'deadlock' outside of A[] and E<>"),
        ("sup{deadlock}: t", "1:5", "'deadlock' outside of A[] and E<>"),
        ("sup t", "1:5", "Expected ':'"),
        ("sup{true: t", "1:4", "not closed"),
        ("sup: t + 1", "1:6", "a clock"),
        ("A[] (true", "1:10", "ends too early"),
        ("A[]", "1:4", "ends too early"),
    ],
)
def test_refusals(explorer: Explorer, text: str, where: str, what: str) -> None:
    with pytest.raises(ModelError) as error:
        explorer.check(text)
    assert error.value.where == f"query:{where}"
    assert what in str(error.value)


def test_misspelt_names_are_guessed(explorer: Explorer) -> None:
    with pytest.raises(ModelError, match="Did you mean 'Cell\\(1\\)'"):
        explorer.check("A[] Cel(1).on")
    with pytest.raises(ModelError, match="Did you mean 'level'"):
        explorer.check("A[] Cell(0).levle == 0")


def test_many_queries_at_once_are_answered_as_one_by_one(model: Network) -> None:
    queries = [
        "A[] last <= 3", "E<> two()", "A[] t <= 3", "sup{Cell(0).on && t <= 4}: t", "E[] true",
        "A[] not deadlock", "E<> t > 4",
    ]  # fmt: skip
    together = Explorer(model).check_all(queries)
    assert [verdict.holds for verdict in together] == [True, True, False, True, True, True, True]
    for query, verdict in zip(queries, together, strict=True):
        alone = Explorer(model).check(query)
        assert (verdict.query, verdict.holds, verdict.extremes) == (alone.query, alone.holds, alone.extremes)
        assert (verdict.trace is None) == (alone.trace is None)


def test_names_that_are_words_of_queries_elsewhere() -> None:
    cell = "P: a -> b; guard: x >= 1; do: supply = 1, sup = 1, U = 1, E[1] = 1, bounds = 1, under = 1"
    named = network(
        "clock x; int[0,1] supply, info, sup, inf, U, W, E[2], A[2], control, bounds, under, strategy, simulate;",
        cell,
    )
    explorer = Explorer(named)
    for query in (
        "supply == 1 --> P.b",
        "info == 1 --> P.b",
        "sup == 1 --> P.b",
        "sup --> P.b",
        "inf == 1 --> P.b",
        "E[1] == 1 --> P.b",
        "A[1] == 1 --> U == W",
        "bounds --> P.b",
        "control --> P.b",
        "simulate --> strategy",
        "P.b --> under == 1",
        "A[] U == 1 || W == 0",
        "A[] control == 0",
        "E<> sup == 1 && supply == 1",
        "inf{sup == 1}: x",
        "sup: sup, U",
    ):
        assert explorer.check(query).holds, query
    assert not explorer.check("A[] U == 0").holds


@pytest.mark.parametrize("word", ["sum", "deadlock", "forall", "imply"])
def test_names_that_are_words_of_every_query_are_refused_where_they_are_declared(word: str) -> None:
    with pytest.raises(ModelError, match=f"'{word}'") as error:
        network(f"int[0,1] {word};", "P: a -> b")
    assert error.value.where == "model.xml:1:28"


# Runs in absolute times, and in words.


def trace(verdict: Verdict) -> Trace:
    assert verdict.trace is not None
    return verdict.trace


def test_a_counterexample_in_words() -> None:
    verdict = verify(fischer(2, wait="x >= 2"), "A[] not (P(1).cs && P(2).cs)")
    assert trace(verdict).lines == (
        "0 ms  P(1) idle → req",
        "0 ms  P(2) idle → req",
        "0 ms  P(1) req → wait  id 0 → 1",
        "2 ms  P(1) wait → cs",
        "2 ms  P(2) req → wait  id 1 → 2",
        "4 ms  P(2) wait → cs",
        "4 ms  not (P(1).cs && P(2).cs): does not hold",
    )


def test_channels_choices_and_changes_are_told() -> None:
    sender = """Sender: idle: x <= 20
        idle -> idle; select: n : int[1,2]; guard: x >= 10; sync: go[n]!; do: all += n, x = 0"""
    receiver = "Receiver: off -> on; sync: go[2]?; do: last = all"
    verdict = verify(
        network("clock x; broadcast chan go[3]; int[0,9] all, last;", sender, receiver), "E<> last == 3"
    )
    assert trace(verdict).lines == (
        "10 ms  go[1]: Sender stays in idle (n = 1)                     all 0 → 1",
        "20 ms  go[2]: Sender stays in idle (n = 2); Receiver off → on  all 1 → 3, last 0 → 3",
        "20 ms  last == 3: holds",
    )


def test_strict_bounds_give_fractions_as_round_as_they_can_be() -> None:
    template = "P: a -> b; guard: x > 1 && x < 2; do: y = 0 | b -> c; guard: x < 2 && y > 0"
    run = trace(verify(network("clock x, y;", template), "E<> P.c"))
    first, second = (step.at for step in run.steps)
    assert 1 < first < second < 2
    assert (first, second) == (Fraction(6, 5), Fraction(7, 5))
    assert run.lines[0].startswith("1.2 ms")


def test_more_strict_bounds_than_any_round_margin_can_keep() -> None:
    edges = [f"s{n} -> s{n + 1}; guard: y > 0 && x < 1; do: y = 0" for n in range(20)]
    run = trace(verify(network("clock x, y;", "P: " + " | ".join(edges)), "E<> P.s20"))
    times = [step.at for step in run.steps]
    assert all(0 < earlier < later < 1 for earlier, later in pairwise(times))


def test_a_run_for_ever_says_where_it_returns_to() -> None:
    template = """P: a: x <= 5 | b: x <= 5 | c: x <= 2
        a -> b; guard: x >= 3 | b -> c; do: x = 0 | c -> b; guard: x >= 1"""
    verdict = verify(network("clock x; bool never;", template), "A<> never")
    run = trace(verdict)
    assert run.loop is not None
    assert run.steps[-1].state.locations == (run.steps[run.loop - 1].state.locations if run.loop else (0,))
    assert run.lines[-1].endswith("repeats indefinitely")
    assert sum("↻" in line for line in run.lines) == len(run.steps) - run.loop


def test_a_leads_to_shows_the_moment_at_which_it_begins() -> None:
    template = "P: b: x <= 9 | a -> b; do: x = 0 | b -> c; guard: x >= 7"
    verdict = verify(network("clock x; bool never;", template), "P.b && x >= 4 --> never")
    assert not verdict.holds
    assert trace(verdict).end >= 4


def test_the_trace_of_a_supremum_reaches_it() -> None:
    template = "P: a: x <= 5 | b: y <= 2 | a -> b; guard: x >= 3; do: y = 0"
    verdict = verify(network("clock x, y;", template), "sup{P.b}: x")
    assert verdict.extremes[0].value == 7
    assert trace(verdict).end == 7
