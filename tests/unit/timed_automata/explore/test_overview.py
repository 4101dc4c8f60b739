"""One exploration says what separate ones say: on random networks, with queries that widen each other's zones."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, note, settings
from hypothesis import strategies as st

from tests.support.nightly import NIGHTLY, PHASES, examples
from tests.unit.timed_automata.explore.models import Template, network
from tests.unit.timed_automata.explore.random_networks import LARGEST, Condition, conditions, networks
from tests.unit.timed_automata.explore.sanity import sanity_check
from timed_automata import Network
from timed_automata.explore import Explorer, overview
from timed_automata.queries import parse_query

pytestmark = pytest.mark.timeout(3600 if NIGHTLY else 120)
many = settings(
    max_examples=examples(20, 2000), deadline=None, suppress_health_check=list(HealthCheck), phases=PHASES
)
places = st.sampled_from(["P0.a", "P0.b", "P1.c", "i == 1", "P0.b && i > 0"])


def shown(network: Network) -> Network:
    note(network.document.source.decode().replace("<", "\n<"))
    return network


@many
@given(networks(), st.lists(conditions(), min_size=1, max_size=3), places, st.integers(0, LARGEST))
def test_queries(network: Network, asked: list[Condition], place: str, bound: int) -> None:
    texts = [f"{kind} {p}" for p in asked for kind in ("A[]", "E<>")]
    texts += [f"A[] ({place}) imply x <= {bound}", f"A[] ({place}) imply y < {bound}", "A[] not deadlock"]
    texts += [f"A[] ({place}) imply ({asked[0]})", f"({place}) --> ({asked[-1]})"]
    found = overview(shown(network), [parse_query(text) for text in texts])
    explorer = Explorer(network)
    for text, answer in zip(texts, found.answers, strict=True):
        holds = explorer.check(text).holds
        if answer is None and ("deadlock" in text or "-->" in text):
            continue  # doubtful: asked again
        assert bool(answer) is holds, text
        assert answer is not None or not holds, text


@many
@given(networks(), places, st.integers(0, LARGEST))
def test_worst_cases(network: Network, place: str, bound: int) -> None:
    query = parse_query(f"A[] ({place}) imply x <= {bound}")
    response = overview(shown(network), [query]).bounded[0]
    exact = Explorer(network).check(f"sup{{{place}}}: x").extremes[0]
    if response.longest is None:
        assert exact.value is None or exact.value > bound or (exact.value == bound and not response.holds)
        assert not (exact.value is None and exact.attained)
    else:
        assert response.longest == exact


@many
@given(networks())
def test_what_can_happen(network: Network) -> None:
    found, sanity = overview(shown(network), []), sanity_check(network)
    assert found.coverage == sanity.coverage
    assert found.open_channels == sanity.open_channels
    assert found.stuck or sanity.deadlock is None
    assert found.stopped or sanity.timelock is None
    assert found.zeno or sanity.zeno is None


def test_what_nobody_reads_costs_no_states() -> None:
    counts = Template("P", ["a -> a; guard: x >= 1; do: x = 0, told = 1", "a -> b"], locations="a b")
    model = network("clock x; int[0, 1] told;", counts)
    there = overview(model, [parse_query("E<> P.b")])
    read = overview(model, [parse_query("E<> P.b && told == 1")])
    assert there.answers == read.answers == (True,)
    assert there.states < read.states


def test_what_the_constants_switch_off_is_told_apart_from_what_is_dead() -> None:
    part = Template(
        "P",
        ["a -> b; guard: FITTED", "b -> c", "a -> d; guard: i == 1", "a -> a"],
        locations="a b c d",
    )
    model = network("const bool FITTED = false; int[0, 1] i;", part)
    coverage = overview(model, []).coverage
    assert coverage.locations == ("P.d",)
    assert [edge.split(": ", 1)[1] for edge in coverage.edges] == ["P a → d (i == 1)"]
    assert [edge.split(": ", 1)[1] for edge in coverage.disabled] == ["P a → b (FITTED)", "P b → c"]


def test_a_conclusion_that_always_holds_has_a_premise_with_a_clock() -> None:
    model = network("clock x;", Template("Only", ["a -> b; guard: x >= 2"]))
    asked = [
        "A[] (Only.a && x >= 1) imply true",
        "A[] Only.a imply true",
        "A[] (Only.b && x < 2) imply 1 == 1",
    ]
    assert overview(model, [parse_query(each) for each in asked]).answers == (True, True, True)
