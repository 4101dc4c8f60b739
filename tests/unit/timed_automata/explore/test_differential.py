"""Verdicts on random networks equal those of the naive explorer of regions."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import product
from random import Random

import pytest
from hypothesis import HealthCheck, given, note, settings
from hypothesis import strategies as st

from tests.support.nightly import NIGHTLY, PHASES, examples
from tests.unit.timed_automata.explore.models import load, network
from tests.unit.timed_automata.explore.random_networks import (
    CLOCKS,
    LARGEST,
    PLACES,
    Condition,
    comparisons,
    conditions,
    networks,
)
from tests.unit.timed_automata.explore.regions import BEYOND, Region, Regions, compare
from tests.unit.timed_automata.simulate.run_facts import assert_is_run
from timed_automata import Execution, Network
from timed_automata.errors import ModelError
from timed_automata.explore import Explorer, Verdict
from timed_automata.inclusion import Interface, trace_inclusion
from timed_automata.simulate import simulate

pytestmark = pytest.mark.timeout(3600 if NIGHTLY else 120)
many = settings(
    max_examples=examples(25, 3000), deadline=None, suppress_health_check=list(HealthCheck), phases=PHASES
)


def both(network: Network, largest: int = LARGEST) -> tuple[Explorer, Regions]:
    note(network.document.source.decode().replace("<", "\n<"))
    return Explorer(network), Regions(network, largest)


@many
@given(networks(), conditions())
def test_reachability(network: Network, p: Condition) -> None:
    explorer, regions = both(network)
    expected = any(p.holds(region) for region in regions.reachable())
    assert explorer.check(f"E<> {p}").holds is expected
    assert explorer.check(f"A[] not ({p})").holds is not expected


@many
@given(networks())
def test_where_and_with_which_clocks_a_run_comes(network: Network) -> None:
    """Each location of each process, with each clock on either side of each number."""
    explorer, regions = both(network)
    reachable = regions.reachable()
    asked, expected = [], []
    for process, place in product((0, 1), range(len(PLACES))):
        there = [region for region in reachable if region.locations[process] == place]
        for clock, op, value in product(range(len(CLOCKS)), ("<", "<=", ">"), range(LARGEST + 1)):
            asked.append(f"E<> P{process}.{PLACES[place]} && {CLOCKS[clock]} {op} {value}")
            expected.append(any(compare(region.clocks[clock], op, value) for region in there))
    found = explorer.check_all(asked)
    assert [verdict.holds for verdict in found] == expected
    for verdict in found:
        if verdict.trace is not None:
            assert list(replayed(verdict, regions))[-1] in reachable


@many
@given(networks(), conditions(1))
def test_deadlock(network: Network, p: Condition) -> None:
    explorer, regions = both(network)
    reachable = regions.reachable()
    stuck = {region for region in reachable if regions.deadlocked(region)}
    assert explorer.check("E<> deadlock").holds is bool(stuck)
    assert explorer.check("A[] not deadlock").holds is not bool(stuck)
    assert explorer.check(f"A[] (deadlock imply {p})").holds is all(map(p.holds, stuck))
    assert explorer.check(f"E<> !deadlock && ({p})").holds is any(map(p.holds, reachable - stuck))


@many
@given(networks())
def test_where_time_stands_still(network: Network) -> None:
    explorer, regions = both(network)

    def stopped(region: Region | None) -> bool:
        while region is not None and (later := regions.later(region)) != region:
            region = later
        return region is None

    stuck = any(regions.deadlocked(region) and stopped(region) for region in regions.reachable())
    assert explorer.timelock().holds is not stuck


@many
@given(networks(), conditions())
def test_staying(network: Network, p: Condition) -> None:
    explorer, regions = both(network)
    expected = regions.stays({regions.initial}, p.holds)
    assert explorer.check(f"E[] {p}").holds is expected
    assert explorer.check(f"A<> not ({p})").holds is not expected


@many
@given(networks(), conditions(1), conditions(1))
def test_leads_to(network: Network, p: Condition, q: Condition) -> None:
    explorer, regions = both(network)
    starts = {region for region in regions.reachable() if p.holds(region)}
    expected = not regions.stays(starts, lambda region: not q.holds(region))
    assert explorer.check(f"{p} --> {q}").holds is expected


@many
@given(networks(), conditions(1), st.sampled_from(CLOCKS))
def test_extremes(network: Network, p: Condition, clock: str) -> None:
    largest = 2 * LARGEST
    explorer, regions = both(network, largest)
    number = network.clocks.index(clock) - 1
    values = [region.clocks[number] for region in regions.reachable() if p.holds(region)]
    (upper,) = explorer.check(f"sup{{{p}}}: {clock}").extremes
    (lower,) = explorer.check(f"inf{{{p}}}: {clock}").extremes
    if not values:
        assert upper.value is None
        assert upper.attained
        return
    if BEYOND in values:
        assert upper.value is None or upper.value > largest or (upper.value == largest and not upper.attained)
    else:
        whole, rank = max((whole, rank > 0) for whole, rank in values)
        assert (upper.value, upper.attained) == (whole + rank, not rank)
    finite = [(whole, rank > 0) for whole, rank in values if whole >= 0]
    if finite:
        whole, rank = min(finite)
        assert (lower.value, lower.attained) == (whole, not rank)


def replayed(verdict: Verdict, regions: Regions) -> Iterator[Region]:
    """All regions along the run of a trace, its delays done in steps from region to region."""
    clocks = [None, *verdict.trace.network.clocks[1:]]
    since, now, region = [Fraction(0)] * len(clocks), Fraction(0), regions.initial
    values = [0] * len(clocks)
    yield region
    for step in (*verdict.trace.steps, None):
        until = step.at if step else verdict.trace.end
        while True:
            ages = [until - at + value for at, value in zip(since, values, strict=True)][1:]
            if _agree(region, ages, regions.largest):
                break
            later = regions.later(region)
            assert later is not None
            assert later != region
            region = later
            yield region
        if step is None:
            return
        taken = [edges for edges in regions.transitions(region) if edges == step.edges]
        assert taken, "the trace takes a transition that is not enabled"
        now = until
        resets: list[tuple[int, int]] = []
        data = list(region.values)
        for edge in step.edges:
            if edge.update:
                edge.update(data, resets)
        for clock, value in resets:
            since[clock], values[clock] = now, value
        region = next(
            after
            for after in regions.actions(region)
            if (after.locations, after.values) == step.state
            and _agree(after, [now - since[n] + values[n] for n in range(1, len(clocks))], regions.largest)
        )
        yield region


def _same(clock: tuple[int, int], age: Fraction, largest: int) -> bool:
    if clock == BEYOND:
        return age > largest
    return clock[0] == int(age) and bool(clock[1]) == (age != int(age))


def _agree(region: Region, ages: list[Fraction], largest: int) -> bool:
    """Whether valuations of these ages are what the region stands for."""
    if not all(_same(clock, age, largest) for clock, age in zip(region.clocks, ages, strict=True)):
        return False
    fractions = [
        (rank, age - int(age)) for (whole, rank), age in zip(region.clocks, ages, strict=True) if whole >= 0
    ]
    return all((a < b) == (x < y) for a, x in fractions for b, y in fractions)


@many
@given(networks(), conditions())
def test_a_trace_is_a_run_that_shows_it(network: Network, p: Condition) -> None:
    explorer, regions = both(network)
    verdict = explorer.check(f"E<> {p}")
    if verdict.holds:
        assert p.holds(list(replayed(verdict, regions))[-1])
    staying = explorer.check(f"E[] {p}")
    if staying.holds:
        assert all(map(p.holds, replayed(staying, regions)))


@many
@given(networks(), st.sampled_from(CLOCKS), st.integers(0, LARGEST))
def test_one_clock_alone(network: Network, clock: str, value: int) -> None:
    explorer, regions = both(network)
    number = network.clocks.index(clock) - 1
    expected = any(compare(region.clocks[number], ">", value) for region in regions.reachable())
    assert explorer.check(f"E<> {clock} > {value}").holds is expected


# Clocks decide who receives a broadcast: a process takes part if, and only if, one of its guards holds.


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
def test_who_receives(first: str, second: str, query: str, holds: bool) -> None:
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
        held = [f"a: {bound}"] * bool(bound)
        texts.append(
            f"P{len(texts)}: committed: {mark} | initial: a | locations: a b c | " + " | ".join(held + edges)
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


def test_it_is_neither_executed_nor_compared() -> None:
    made = load(LATE.format(first="x > 3", second="x > 4"))
    for refused in (
        lambda: Execution(made, ["R"], ["n"]),
        lambda: trace_inclusion(made, made, Interface(environment=["S"], observed=["n"])),
    ):
        with pytest.raises(ModelError, match=r"a clock guard on a receiver.*Receive it without the guard"):
            refused()


def test_the_contrary_of_a_guard_is_asked_for_as_well() -> None:
    """Beyond a lower bound a zone must not be widened to where the guard fails: somebody asks where it fails."""
    made = load(
        """clock x, y; broadcast chan b;
        process S() { state W, A, B; init W; trans W -> A { guard y >= 3; }, A -> B { sync b!; }; }
        process R() { state C, D; init C; trans C -> D { guard x >= 2; sync b?; }; }
        system S, R;"""
    )
    assert Explorer(made).check("A[] S.B imply R.D").holds
