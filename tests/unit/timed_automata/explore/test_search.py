"""What a search keeps of a state: limits of its clocks, shared plans and zones, stages that it leaves for good."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable

import pytest
from hypothesis import HealthCheck, given, note, settings

from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import ModelError, RangeError
from tests.support.nightly import NIGHTLY, PHASES, examples
from tests.unit.timed_automata.explore.classics import csma_cd, fischer, train_gate
from tests.unit.timed_automata.explore.models import network
from tests.unit.timed_automata.explore.random_networks import networks
from timed_automata import Network, load_network
from timed_automata.explore.search import Search
from timed_automata.explore.search._reach import WidestFirst
from timed_automata.explore.search._stages import SearchNode, Stage, Stages
from timed_automata.explore.states import DiscreteSpace, SymbolicSpace
from timed_automata.explore.zones import Limits, included
from timed_automata.explore.zones._limits import NEVER, Limit, QueryLimits, largest, limits_of
from timed_automata.explore.zones._zone import INFINITY, UniqueZones, at_most, below
from timed_automata.network import Semantics
from timed_automata.queries import compile_formula, parse_query


def test_limits_run_back_along_the_edges_until_a_clock_is_set() -> None:
    edges = ["a -> b; do: x = 0", "b -> c", "c -> d; guard: x >= 5", "d -> a", "d -> e; guard: y < 7"]
    edges.append("e -> e; guard: false && x > 99")
    model = network("clock x, y;", " | ".join(["P: b: x <= 3", *edges]))
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
        "P: a: x <= T[i] + i | a -> b; guard: x >= T[i] && x <= i + 3",
    )
    assert Limits(model).at((0,)) == {1: Limit(70, 72)}


def test_a_set_that_may_not_happen_does_not_count() -> None:
    declarations = "clock x; bool b; void maybe() { if (b) b = false; }"
    model = network(declarations, "P: a -> b; do: maybe() | b -> c; guard: x > 4")
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
    model = network("const int N = 3; int[0, 2] i; clock x;", "P: a -> b")
    asked = parse_query(f"A[] {condition}").condition
    assert asked is not None
    assert limits_of(compile_formula(model, asked, negated=True)) == limits


def test_a_constant_too_large_is_refused() -> None:
    model = network("clock x; const int A = 2000000000; const int B = 1000;", "P: a -> b; guard: x > A * B")
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
    model = network(
        "int[0, 3] k; int m[2];",
        """P:
        a -> a; guard: k == 2 && m[1] != 3
        a -> a; guard: m[1] != 0 && 1 == k && m[k] == 0
        a -> a; guard: m[k] == 0 && k == 2
        a -> a; guard: k == 0 || k == 1
        a -> a; guard: k == m[0]""",
    )
    at = model.offsets["k"]
    assert [edge.guard.needed for edge in model.processes[0].edges] == [((at, 2),), ((at, 1),), (), (), ()]


def test_a_guard_that_fails_before_it_asks_for_its_value_still_fails() -> None:
    model = network("int[0, 3] k = 3; int m[2];", "P: a -> a; guard: m[k] == 0 && k == 2")
    with pytest.raises(RangeError):
        list(DiscreteSpace(model).semantics.transitions(model.initial))


# What symbolic states share: plans, and zones.


def test_moves_that_are_alike_but_for_their_clocks_share_a_plan() -> None:
    """Each process of Fischer's protocol may ask first: what becomes of the zone is the same, of another clock."""
    model = fischer(3)
    space = SymbolicSpace(DiscreteSpace(model), Limits(model))
    first, _ = space.initial()
    plans, targets = zip(*[(plan, target) for plan, target, _ in first.steps], strict=True)
    assert len({target.form.clocks for target in targets}) == 3
    assert len(set(map(id, plans))) == 1


def test_equal_zones_of_a_search_are_one_object() -> None:
    search = Search(SymbolicSpace(DiscreteSpace(model := fischer(3)), Limits(model)))
    zones = {id(node.zone): tuple(node.zone) for node in search.nodes()}
    assert len(zones) == len(set(zones.values())) > 10


def test_zones_with_one_hash_stay_apart() -> None:
    """``x >= 1`` and ``x > 1``: Python hashes -1 as -2."""
    least, more = ((1, bound, INFINITY, 1) for bound in (at_most(-1), below(-1)))
    assert hash(least) == hash(more)
    unique = UniqueZones()
    found = [unique.of(zone) for zone in (least, more, least, more)]
    assert [tuple(zone) for zone in found] == [least, more, least, more]
    assert found[0] is found[2] is not found[1] is found[3]
    assert len(unique) == 2


def test_many_zones_of_one_discrete_state_take_memory_for_themselves_only() -> None:
    """Pairs that were compared are not remembered: that would take 12 kB for each state here."""
    resets = [f"a -> a; guard: x{i} >= {1 + i}; do: x{i} = 0" for i in range(4)]
    invariant = " && ".join(f"x{i} <= {2 + i}" for i in range(4))
    model = network("clock x0, x1, x2, x3;", " | ".join([f"P: a: {invariant}", *resets]))
    tracemalloc.start()
    search = Search(SymbolicSpace(DiscreteSpace(model), Limits(model)))
    states = sum(1 for _ in search.nodes())
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    left = search.space.initial()[0].passed
    assert states > 400
    assert not any(_inside(one, other) for one in left for other in left if one is not other)
    assert peak < 4_000 * states, peak / states


def _inside(one: SearchNode, other: SearchNode) -> bool:
    return included(one.zone, other.zone)


# What a search may forget: stages are left for good, on random networks and where it can be counted.


pytestmark = pytest.mark.timeout(3600 if NIGHTLY else 120)


@settings(
    max_examples=examples(30, 3000), deadline=None, suppress_health_check=list(HealthCheck), phases=PHASES
)
@given(networks())
def test_a_step_stays_in_its_stage_or_leads_to_a_higher_rank(model: Network) -> None:
    note(model.document.source.decode().replace("<", "\n<"))
    search, stages = Search(SymbolicSpace(DiscreteSpace(model), Limits(model))), Stages(model)
    for _ in search.nodes():
        pass
    for record in list(search.space.records):
        here = stages.of(record, None)
        for _, target, move in record.steps:
            there = stages.of(target, None)
            assert move.error or there is here or there.level.rank > here.level.rank
            assert stages.of(target, here) is there or move.error


def test_stages_are_forgotten_one_by_one() -> None:
    """Three values are chosen and stay; then a counter runs: three stages of five states, never two at once."""
    counts = """P: locations: a b
        a -> b; guard: chosen == 0; do: chosen = 1
        a -> b; guard: chosen == 0; do: chosen = 2
        a -> b; guard: chosen == 0; do: chosen = 3
        b -> b; guard: x >= 1; do: x = 0, i = i < 4 ? i + 1 : 0"""
    model = network("clock x; int[0, 3] chosen; int[0, 4] i;", counts)
    sizes: list[tuple[int, int]] = []

    def done(stage: Stage) -> None:
        sizes.append((len(stage.records), len(search.space)))
        for record in stage.records:
            search.space.drop(record)

    search = WidestFirst(SymbolicSpace(DiscreteSpace(model), Limits(model)), [], done=done)
    for _ in search.nodes():
        pass
    assert sizes[0] == (1, 4)  # the first state, and where it leads
    assert [size for size, _ in sizes[1:]] == [5, 5, 5]
    assert max(kept for _, kept in sizes) <= 5 + 2
    assert len(search.space) == len(search.space.discrete) == 0
