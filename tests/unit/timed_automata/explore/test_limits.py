"""Limits of clocks by location."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import ModelError, RangeError
from tests.unit.timed_automata.explore.classics import csma_cd, fischer, train_gate
from tests.unit.timed_automata.explore.models import Template, network
from timed_automata import Network, load_network
from timed_automata.explore.states._discrete import DiscreteSpace
from timed_automata.explore.zones._limits import NEVER, Limit, Limits, QueryLimits, largest, limits_of
from timed_automata.network import Semantics
from timed_automata.queries import compile_formula, parse_query


def test_limits_run_back_along_the_edges_until_a_clock_is_set() -> None:
    edges = ["a -> b; do: x = 0", "b -> c", "c -> d; guard: x >= 5", "d -> a", "d -> e; guard: y < 7"]
    edges.append("e -> e; guard: false && x > 99")
    model = network("clock x, y;", Template("P", edges, invariants={"b": "x <= 3"}))
    limits = Limits(model)
    y = Limit(NEVER, 7)
    assert [limits.at((place,)) for place in range(5)] == [
        {2: y},  # a: x is set before it is asked for
        {1: Limit(5, 3), 2: y},
        {1: Limit(5, NEVER), 2: y},
        {2: y},
        {},
    ]
    assert Limits(model, symmetric=True).at((1,)) == {1: Limit(5, 5), 2: Limit(7, 7)}
    assert Limits(model, [QueryLimits({1: Limit(NEVER, 9)})]).at((0,))[1] == Limit(NEVER, 9)
    assert largest(model) == 7


def test_bounds_that_depend_on_data_count_with_the_largest_value() -> None:
    declarations = "const int T[3] = {40, 70, 20}; int[0,2] i; clock x;"
    model = network(
        declarations,
        Template("P", ["a -> b; guard: x >= T[i] && x <= i + 3"], invariants={"a": "x <= T[i] + i"}),
    )
    assert Limits(model).at((0,)) == {1: Limit(70, 72)}


def test_a_set_that_may_not_happen_does_not_count() -> None:
    declarations = "clock x; bool b; void maybe() { if (b) b = false; }"
    model = network(declarations, Template("P", ["a -> b; do: maybe()", "b -> c; guard: x > 4"]))
    assert Limits(model).at((0,)) == {1: Limit(4, NEVER)}


def test_clocks_of_several_processes() -> None:
    limits = Limits(fischer(2)).at
    assert limits((0, 0)) == {}
    assert limits((1, 0)) == {1: Limit(NEVER, 2)}
    assert limits((1, 2)) == {1: Limit(NEVER, 2), 2: Limit(2, NEVER)}


@pytest.mark.parametrize(
    ("condition", "limits"),
    [
        ("N > 1 || x >= 5", {}),
        ("N == 1 && i > 0 imply x >= 5", {}),
        ("N > 3 || x >= 5", {1: Limit(NEVER, 5)}),
        ("i > 1 || x >= 5", {1: Limit(NEVER, 5)}),
        ("(N > 1 ? i > 0 : x >= 7) && (N > 2 imply x >= 5)", {1: Limit(NEVER, 5)}),
    ],
)
def test_what_constants_decide_in_a_query_asks_for_no_clock(condition: str, limits: dict[int, Limit]) -> None:
    model = network("const int N = 3; int[0, 2] i; clock x;", Template("P", ["a -> b"]))
    asked = parse_query(f"A[] {condition}").condition
    assert asked is not None
    assert limits_of(compile_formula(model, asked, negated=True)) == limits


def test_a_constant_too_large_is_refused() -> None:
    model = network(
        "clock x; const int A = 2000000000; const int B = 1000;", Template("P", ["a -> b; guard: x > A * B"])
    )
    with pytest.raises(ModelError, match="The largest that is supported"):
        Limits(model)


@pytest.mark.parametrize(
    "made",
    [
        lambda: fischer(3),
        lambda: train_gate(2),
        lambda: csma_cd(2),
        lambda: load_network(load(profile_path()).automata_path),
    ],
    ids=["fischer", "train", "csma", "gripper"],
)
def test_the_quick_semantics_is_the_semantics(made: Callable[[], Network]) -> None:
    model = made()
    space, plain = DiscreteSpace(model), Semantics(model)
    waiting, seen = [space.at(model.initial)], {model.initial}
    while waiting and len(seen) < 1500:
        discrete = waiting.pop()
        assert discrete is not None
        expected = list(plain.transitions(discrete.state))
        assert list(space.semantics.transitions(discrete.state)) == expected
        assert discrete.delays is plain.may_delay(discrete.state)
        assert list(discrete.invariant) == plain.invariant(discrete.state)
        for move in discrete.moves:
            if move.target is not None and move.target.state not in seen:
                seen.add(move.target.state)
                waiting.append(move.target)
    assert len(seen) > 8


def test_a_guard_says_which_value_it_needs() -> None:
    edges = [
        "a -> a; guard: k == 2 && m[1] != 3",
        "a -> a; guard: m[1] != 0 && 1 == k && m[k] == 0",
        "a -> a; guard: m[k] == 0 && k == 2",
        "a -> a; guard: k == 0 || k == 1",
        "a -> a; guard: k == m[0]",
    ]
    model = network("int[0, 3] k; int m[2];", Template("P", edges))
    at = model.offsets["k"]
    assert [edge.guard.needed for edge in model.processes[0].edges] == [((at, 2),), ((at, 1),), (), (), ()]


def test_a_guard_that_fails_before_it_asks_for_its_value_still_fails() -> None:
    model = network("int[0, 3] k = 3; int m[2];", Template("P", ["a -> a; guard: m[k] == 0 && k == 2"]))
    with pytest.raises(RangeError):
        list(DiscreteSpace(model).semantics.transitions(model.initial))
