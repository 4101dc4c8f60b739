"""Reading queries: what is understood, and what is refused by name and position."""

from __future__ import annotations

import pytest

from end_effector_hal.errors import ModelError
from tests.unit.timed_automata.explore.models import Template, network
from timed_automata import Network
from timed_automata.explore import Explorer
from timed_automata.queries import parse_query


@pytest.fixture(scope="module")
def model() -> Network:
    cell = Template(
        "Cell",
        ["off -> on; guard: x >= id + 1; do: x = 0, level = id + 1, last = id", "on -> off; do: level = 0"],
        parameters="const int[0,3] id",
        declarations="clock x; int[0,4] level; int[0,3] pair[2];",
    )
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
        "A[] last <= 3",
        "E<> two()",
        "A[] t <= 3",
        "sup{Cell(0).on && t <= 4}: t",
        "E[] true",
        "A[] not deadlock",
        "E<> t > 4",
    ]
    together = Explorer(model).check_all(queries)
    assert [verdict.holds for verdict in together] == [True, True, False, True, True, True, True]
    for query, verdict in zip(queries, together, strict=True):
        alone = Explorer(model).check(query)
        assert (verdict.query, verdict.holds, verdict.extremes) == (alone.query, alone.holds, alone.extremes)
        assert (verdict.trace is None) == (alone.trace is None)


def test_names_that_are_words_of_queries_elsewhere() -> None:
    cell = Template(
        "P", ["a -> b; guard: x >= 1; do: supply = 1, sup = 1, U = 1, E[1] = 1, bounds = 1, under = 1"]
    )
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
        network(f"int[0,1] {word};", Template("P", ["a -> b"]))
    assert error.value.where == "model.xml:1:28"
