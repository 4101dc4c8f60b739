"""Verdicts on random networks equal those of the naive explorer of regions."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import product

import pytest
from hypothesis import HealthCheck, given, note, settings
from hypothesis import strategies as st

from tests.support.nightly import NIGHTLY, PHASES, examples
from tests.unit.timed_automata.explore.random_networks import (
    CLOCKS,
    LARGEST,
    PLACES,
    Condition,
    conditions,
    networks,
)
from tests.unit.timed_automata.explore.regions import BEYOND, Region, Regions, compare
from timed_automata import Network
from timed_automata.explore import Explorer, Verdict

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
    assert verdict.trace is not None
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
