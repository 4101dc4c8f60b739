"""One exploration says what separate ones say, and what is found in every model, asked for or not."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, note, settings
from hypothesis import strategies as st

from tests.support.nightly import NIGHTLY, PHASES, examples
from tests.unit.timed_automata.explore.models import network
from tests.unit.timed_automata.explore.random_networks import LARGEST, Condition, conditions, networks
from tests.unit.timed_automata.explore.sanity import SanityReport, sanity_check
from timed_automata import Network
from timed_automata.explore import Explorer, ReactionBound, overview
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
    counts = "P: locations: a b | a -> a; guard: x >= 1; do: x = 0, told = 1 | a -> b"
    model = network("clock x; int[0, 1] told;", counts)
    there = overview(model, [parse_query("E<> P.b")])
    read = overview(model, [parse_query("E<> P.b && told == 1")])
    assert there.answers == read.answers == (True,)
    assert there.states < read.states


def test_what_the_constants_switch_off_is_told_apart_from_what_is_dead() -> None:
    part = "P: locations: a b c d | a -> b; guard: FITTED | b -> c | a -> d; guard: i == 1 | a -> a"
    model = network("const bool FITTED = false; int[0, 1] i;", part)
    coverage = overview(model, []).coverage
    assert coverage.locations == ("P.d",)
    assert [edge.split(": ", 1)[1] for edge in coverage.edges] == ["P a → d (i == 1)"]
    assert [edge.split(": ", 1)[1] for edge in coverage.disabled] == ["P a → b (FITTED)", "P b → c"]


def test_a_conclusion_that_always_holds_has_a_premise_with_a_clock() -> None:
    model = network("clock x;", "Only: a -> b; guard: x >= 2")
    asked = [
        "A[] (Only.a && x >= 1) imply true",
        "A[] Only.a imply true",
        "A[] (Only.b && x < 2) imply 1 == 1",
    ]
    assert overview(model, [parse_query(each) for each in asked]).answers == (True, True, True)


# What is found in every model, asked for or not.


def survey(declarations: str, *templates: str, system: str = "") -> SanityReport:
    return sanity_check(network(declarations, *templates, system=system))


def test_a_sound_model_is_ok() -> None:
    found = survey("clock x;", "P: a: x <= 2 | b: x <= 2 | a -> b; guard: x >= 1; do: x = 0 | b -> a")
    assert found.ok
    assert found.diverges
    assert found.complete
    assert found.states == 2


def test_locations_and_edges_are_judged_by_template() -> None:
    cell = """Cell(const int[0,1] id): own: clock x;
        a -> b; guard: id == 1 && x >= 1; do: x = 0
        b -> a; guard: x >= 1; do: x = 0
        a -> c; guard: id == 2"""
    found = survey("int[0,1] n;", cell)
    assert found.coverage.locations == ("Cell.c",)
    assert [edge.partition(": ")[2] for edge in found.coverage.edges] == ["Cell a → c (id == 2)"]
    assert found.coverage.edges[0].startswith("model.xml:1:")


def test_channels_with_one_end() -> None:
    loops = "P: a -> a; guard: x >= 1; sync: out[1]!; do: x = 0 | a -> a; sync: into?"
    found = survey("clock x; broadcast chan out[2]; chan into, none;", loops)
    assert found.open_channels == (
        "out[0]: no edge uses it",
        "out[1]: no edge receives on it",
        "into: no edge sends on it",
        "none: no edge uses it",
    )
    assert not found.complete


def test_a_terminal_location_is_a_deadlock_and_no_timelock() -> None:
    found = survey("", "P: a -> b")
    assert found.deadlock is not None
    assert found.timelock is None
    assert found.diverges


@pytest.mark.parametrize("more", ["b: x <= 2", "urgent: b", "committed: b"])
def test_where_time_cannot_go_on(more: str) -> None:
    found = survey("clock x;", f"P: a -> b; do: x = 0 | {more}")
    assert found.timelock.lines[-1].endswith("no transition is possible, and time cannot go on")
    assert not found.diverges


@pytest.mark.parametrize(
    ("cycle", "zeno"),
    [
        ("a -> b | b -> a", True),
        ("a -> b; do: x = 0 | b -> a", True),  # set, not tested
        ("a -> b; guard: x >= 1 | b -> a", True),  # tested, not set
        ("a -> b; guard: x > 0; do: x = 0 | b -> a", True),  # converges
        ("a -> b; guard: x >= 1 | b -> a; do: x = 0", False),
        ("a -> b; guard: x >= 1; do: x = 1 | b -> a", True),  # set to 1 is at least 1
        # every cycle needs its own clock: the last one sets y, then x, and tests neither
        ("a -> a; guard: x >= 1; do: x = 0 | a -> b; guard: y >= 2 | b -> a; do: y = 0", False),
        ("a -> b; guard: x >= 1 | b -> a; do: y = 0 | b -> c; guard: y >= 1 | c -> b; do: x = 0", True),
    ],
)
def test_zeno_cycles(cycle: str, zeno: bool) -> None:
    assert (survey("clock x, y;", f"P: {cycle}").zeno is not None) is zeno


def test_a_zeno_cycle_inside_a_larger_one() -> None:
    cycles = "P: a -> b; guard: x >= 1; do: x = 0 | b -> a | b -> c; do: y = 0 | c -> b; guard: y >= 0"
    found = survey("clock x, y;", cycles)
    cycle = found.zeno.steps[found.zeno.loop :]
    assert {step.state.locations for step in cycle} == {(1,), (2,)}


def test_counters_end_a_cycle() -> None:
    """The unwinding of a gripper goes through its steps in no time, but only once."""
    found = survey(
        "clock x; int[0,3] k;",
        """P: committed: b | a -> b; guard: x >= 1; do: k = 0, x = 0
        b -> b; guard: k < 3; do: k++ | b -> a; guard: k == 3""",
    )
    assert found.zeno is None
    assert found.ok


def test_what_answers_is_driven_by_what_asks() -> None:
    asker = "A: a -> a; guard: x >= 1; sync: ask!; do: x = 0"
    answerer = "B: a -> b; sync: ask? | b -> a; sync: ask?"
    assert survey("clock x; broadcast chan ask;", asker, answerer).ok
    ping = "A: a -> b; sync: ping! | b -> a; sync: pong?"
    pong = "B: a -> b; sync: ping? | b -> a; sync: pong!"
    assert survey("chan ping, pong;", ping, pong).zeno is not None


# What is executed is due so long before its invariant ends it as its reactions may be late, no less and no more.


BOUND = ReactionBound(("P",), 5)


def late(
    invariant: str, *edges: str, executed: str = "P", other: str = "w -> w; sync: go!"
) -> tuple[str, ...]:
    made = network(
        "broadcast chan go; clock t; bool on; int[0, 9] n = 3;",
        " | ".join([f"{executed}: a: {invariant}", *edges, "b -> a; guard: t >= 20; do: t = 0"]),
        f"World: {other}",
    )
    return overview(made, [], reaction=BOUND).late


@pytest.mark.parametrize(
    ("invariant", "edge", "expected"),
    [
        ("t <= 15", "a -> b; guard: t >= 10", ()),
        ("t < 16", "a -> b; guard: t >= 10", ()),
        ("t <= 15", "a -> b; guard: t > 9", ()),
        ("t <= 15", "a -> b; guard: t >= 11", ("P.a: 4 instead of 5",)),
        ("t <= 16", "a -> b; guard: t >= 10", ("P.a: 6 instead of 5",)),
        ("t <= 15", "a -> b; guard: t >= 10; sync: go?", ("P.a: no edge is due",)),
        ("t <= 15", "a -> b; guard: t >= 10; sync: go!", ()),
        ("t <= 15", "a -> b; guard: t >= 10 && on", ("P.a: no edge is due",)),
        ("t <= 5 * n", "a -> b; guard: t >= 5 * n - 5", ()),
        ("t <= 15", "a -> b", ("P.a: 15 instead of 5",)),
    ],
)
def test_the_room_of_a_time_out(invariant: str, edge: str, expected: tuple[str, ...]) -> None:
    other = "w -> w" if "go?" in edge or "go" not in edge else "w -> w; sync: go?"
    if "go?" in edge:  # a receiver of a broadcast channel has no clock in its guard
        edge = edge.replace("guard: t >= 10; ", "")
    assert late(invariant, edge, other=other) == expected


def test_what_is_due_in_time_is_enough_also_where_something_else_may_happen_earlier() -> None:
    assert late("t <= 15", "a -> b; guard: t >= 10", "a -> b; guard: t >= 2") == ()


def test_the_environment_needs_none() -> None:
    assert late("t <= 15", "a -> b; guard: t >= 11", executed="Sensors") == ()
