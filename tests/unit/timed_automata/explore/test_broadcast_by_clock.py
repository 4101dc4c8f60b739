"""Clocks decide who receives a broadcast: a process takes part if, and only if, one of its guards holds."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

import pytest
from hypothesis import given, note
from hypothesis import strategies as st

from tests.support.nightly import NIGHTLY
from tests.unit.timed_automata.explore.models import Template, network
from tests.unit.timed_automata.explore.random_networks import LARGEST, comparisons
from tests.unit.timed_automata.explore.regions import Regions
from tests.unit.timed_automata.explore.test_differential import many
from tests.unit.timed_automata.simulate.run_facts import assert_is_run
from timed_automata import Execution, Network
from timed_automata.errors import ModelError
from timed_automata.explore import Explorer
from timed_automata.inclusion import Interface, trace_inclusion
from timed_automata.simulate import simulate

pytestmark = pytest.mark.timeout(3600 if NIGHTLY else 120)

LATE = """clock x, y; broadcast chan b; int[0,3] n;
process S() {{ state A {{ x <= 5 }}, B; init A; trans A -> B {{ sync b!; assign y = 0; }}; }}
process R() {{ state C, D, E; init C; trans C -> D {{ guard {first}; sync b?; assign n = 1; }},
  C -> E {{ guard {second}; sync b?; assign n = 2; }}; }}
system S, R;"""


@pytest.mark.parametrize(
    ("first", "second", "query", "holds"),
    [
        ("x > 3", "x > 4", "E<> S.B && R.C", True),
        ("x > 3", "x > 4", "E<> S.B && R.C && y == 0 && x > 3", False),  # it cannot stay away
        ("x > 3", "x > 4", "E<> S.B && R.C && y == 0 && x == 3", True),
        ("x > 3", "x > 4", "E<> S.B && R.D && y == 0 && x <= 3", False),
        ("x > 3", "x > 4", "E<> S.B && R.E && y == 0 && x <= 4", False),
        ("x > 3", "x > 4", "E<> S.B && R.D && y == 0 && x == 5", True),  # either of them
        ("x > 3", "x <= 3", "E<> S.B && R.C", False),  # one always holds
        ("x > 3", "x < 3", "E<> S.B && R.C && y == 0 && (x < 3 || x > 3)", False),
        ("x > 3", "x < 3", "E<> S.B && R.C && y == 0 && x == 3", True),
        ("x == 2", "x >= 1 && x < 2", "E<> S.B && R.C && y == 0 && x >= 1 && x <= 2", False),
        ("x == 2", "x >= 1 && x < 2", "E<> S.B && R.C && y == 0 && x < 1", True),
        ("x == 2", "x >= 1 && x < 2", "E<> S.B && R.C && y == 0 && x > 2", True),
        ("n == 1 && x > 3", "n == 0 && x > 4", "E<> S.B && R.D", False),
        ("n == 1 && x > 3", "n == 0 && x > 4", "E<> S.B && R.C && y == 0 && x == 4", True),
        ("n == 1 && x > 3", "n == 0 && x > 4", "E<> S.B && R.C && y == 0 && x > 4", False),
    ],
)  # fmt: skip
def test_who_receives(
    load: Callable[[str], Network], first: str, second: str, query: str, holds: bool
) -> None:
    assert Explorer(load(LATE.format(first=first, second=second))).check(query).holds is holds


@st.composite
def listeners(draw: st.DrawFn) -> Network:
    """Two processes that listen, often by clocks, one that sends, and one that listens and sends."""
    texts = []
    for kind in ("?", "?", "!?"):
        edges = []
        for _ in range(draw(st.integers(1, 4))):
            sync = f"; sync: b{draw(st.sampled_from(kind))}" if draw(st.integers(0, 3)) else ""
            guards = draw(st.lists(comparisons(), max_size=2))
            if draw(st.integers(0, 4)) == 0:
                guards.append(draw(st.sampled_from(("i == 0", "i > 0"))))
            update = draw(st.sampled_from(("", "", "x = 0", "y = 0", "i = 2 - i")))
            ends = draw(st.sampled_from(("a -> a", "a -> b", "b -> a", "b -> c", "a -> c")))
            guard = f"; guard: {' && '.join(guards)}" if guards else ""
            edges.append(ends + guard + sync + (f"; do: {update}" if update else ""))
        bound = draw(st.sampled_from(("", f"x <= {LARGEST}", "y < 2")))
        mark = draw(st.sampled_from(("", "", "b")))
        texts.append(
            Template(
                f"P{len(texts)}",
                edges,
                invariants={"a": bound} if bound else {},
                committed=mark,
                initial="a",
                locations="a b c",
            )
        )
    return network("clock x, y; int[0,2] i; broadcast chan b;", *texts)


@many
@given(listeners(), st.integers(0, 2), st.sampled_from("abc"), comparisons())
def test_as_the_regions_say(made: Network, process: int, place: str, clock: str) -> None:
    note(made.document.source.decode().replace("<", "\n<"))
    explorer, regions = Explorer(made), Regions(made, LARGEST)
    reachable = regions.reachable()
    for at, name in enumerate("abc"):
        for number in range(3):
            expected = any(region.locations[number] == at for region in reachable)
            assert explorer.check(f"E<> P{number}.{name}").holds is expected
    stuck = any(map(regions.deadlocked, reachable))
    assert explorer.check("A[] not deadlock").holds is not stuck
    at = "abc".index(place)
    staying = regions.stays({regions.initial}, lambda region: region.locations[process] != at)
    assert explorer.check(f"A<> P{process}.{place}").holds is not staying


@many
@given(listeners(), st.integers(0, 1 << 32))
def test_a_simulated_run_is_one(made: Network, seed: int) -> None:
    assert_is_run(simulate(made, Random(seed), steps=20).trace)


def test_it_is_neither_executed_nor_compared(load: Callable[[str], Network]) -> None:
    made = load(LATE.format(first="x > 3", second="x > 4"))
    for refused in (
        lambda: Execution(made, ["R"], ["n"]),
        lambda: trace_inclusion(made, made, Interface(environment=["S"], observed=["n"])),
    ):
        with pytest.raises(ModelError, match=r"a clock guard on a receiver.*Receive it without the guard"):
            refused()


def test_the_contrary_of_a_guard_is_asked_for_as_well(load: Callable[[str], Network]) -> None:
    """Beyond a lower bound a zone must not be widened to where the guard fails: somebody asks where it fails."""
    made = load(
        """clock x, y; broadcast chan b;
        process S() { state W, A, B; init W; trans W -> A { guard y >= 3; }, A -> B { sync b!; }; }
        process R() { state C, D; init C; trans C -> D { guard x >= 2; sync b?; }; }
        system S, R;"""
    )
    assert Explorer(made).check("A[] S.B imply R.D").holds
