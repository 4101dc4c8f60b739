"""What a proof says of small models: verdicts, runs, worst cases, and what no query says."""

from __future__ import annotations

from time import process_time
from typing import Any

import pytest
from hypothesis import HealthCheck, given, note, settings

from end_effector_hal.errors import ModelError
from end_effector_hal.verification.proof import Finding, Proof, Requirement, WorstCase, prove
from end_effector_hal.verification.proof import _checks as checking
from end_effector_hal.verification.proof import _prove as proving
from tests.support.nightly import NIGHTLY, PHASES, examples
from tests.unit.timed_automata.explore.models import network
from tests.unit.timed_automata.explore.random_networks import LARGEST, Condition, conditions, networks
from tests.unit.timed_automata.explore.regions import Region, Regions
from timed_automata import Network, make_network
from timed_automata.explore import Overview, overview
from timed_automata.queries import parse_query

GOOD = ["locations", "edges", "channels", "names", "time"]


def finding(proof: Proof, id_: str) -> Finding:
    return next(each for each in proof.findings if each.id == id_)


def failing(proof: Proof) -> list[str]:
    return [each.id for each in proof.findings if not each.holds]


def lamp(*queries: tuple[str, str], press: str = "x >= 2") -> Network:
    """A lamp that goes off by itself between 5 and 6 after it went on."""
    lit = """Lamp: own: clock y; | on: y <= 6
        off -> on; sync: press?; do: y = 0
        on -> off; guard: y >= 5"""
    person = f"Person: idle -> idle; guard: {press}; sync: press!; do: x = 0"
    return network("clock x; broadcast chan press;", lit, person, queries=queries)


def test_requirements_keep_the_order_of_the_file_and_the_checks_follow() -> None:
    proof = prove(lamp(("A[] not deadlock", "[alive] It goes on."), ("E<> Lamp.on", "It can be lit.")))
    assert [(each.id, each.sentence) for each in proof.findings[:2]] == [
        ("alive", "It goes on."),
        ("query-2", "It can be lit."),
    ]
    assert [each.id for each in proof.findings[2:]] == GOOD
    assert proof.holds
    assert all(each.trace is None for each in proof.findings)


def test_what_does_not_hold_comes_with_its_shortest_run() -> None:
    proof = prove(lamp(("A[] Lamp.off", "[dark] It stays dark."), ("E<> Lamp.on && x > 5", "[late]")))
    assert failing(proof) == ["dark"]
    trace = finding(proof, "dark").trace
    assert [step.at for step in trace.steps] == [2]


def test_worst_cases_are_computed_beside_their_bounds() -> None:
    proof = prove(lamp(("A[] Lamp.on imply Lamp.y <= 7", "[lit] Not for long.")))
    assert proof.bounds == {"lit_s": WorstCase(6, 7)}
    late = prove(lamp(("A[] Lamp.on imply Lamp.y <= 3", "[lit] Not for long.")))
    assert late.bounds == {"lit_s": WorstCase(6, 3)}
    assert finding(late, "lit").remark == "takes up to 6 ms, 3 ms are required"
    assert finding(late, "lit").trace is not None


def test_a_worst_case_far_beyond_its_bound_is_not_searched_for_ever() -> None:
    proof = prove(lamp(("A[] Person.idle imply x <= 100", "[pressed]")))  # nobody has to press
    assert finding(proof, "pressed").worst == WorstCase(None, 100, at_least_ms=400)
    assert finding(proof, "pressed").remark == "takes at least 400 ms, 100 ms are required"
    assert proof.document()["bounds"] == {"pressed_s": {"computed": None, "declared": 0.1, "at_least": 0.4}}


def test_a_worst_case_that_takes_too_many_states_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    counts = "P: a: y <= 1 | a -> a; guard: y >= 1; do: y = 0, n = (n + 1) % 500"
    late = network("clock x, y; int[0,499] n;", counts, queries=[("A[] P.a imply x <= 20", "[late]")])
    monkeypatch.setattr(proving, "_LONG", 0.02)
    worst = finding(prove(late), "late").worst
    assert worst.computed_ms is None
    assert worst.at_least_ms is not None
    assert 20 <= worst.at_least_ms < 80
    assert str(worst) == f"at least {worst.at_least_ms / 1000:g} s"


def test_a_value_out_of_range_ends_the_proof_with_its_run() -> None:
    counter = "P: a: x <= 4 | a -> a; guard: x >= 2; do: n = n + 1, x = 0"
    proof = prove(network("clock x; int[0,2] n;", counter, queries=[("A[] n < 3", "[few]")]))
    assert [each.id for each in proof.findings] == ["ranges", "few"]
    assert not any(each.holds for each in proof.findings)
    trace = proof.findings[0].trace
    assert [step.at for step in trace.steps] == [2, 4]
    assert "out of its range" in proof.findings[0].remark


def test_a_query_that_leaves_an_array_ends_the_proof_and_says_where() -> None:
    counter = "P: a: x <= 4 | a -> a; guard: x >= 2; do: n = 1 - n, x = 0"
    asked = [("A[] n < 3", "[few]"), ("A[] seen[n + 1] == 0", "[seen]")]
    proof = prove(network("clock x; int[0,1] n; int seen[2];", counter, queries=asked))
    assert [each.id for each in proof.findings] == ["ranges", "few", "seen"]
    assert not any(each.holds for each in proof.findings)
    assert "Index 2 of 'seen' is outside of 0 to 1." in proof.findings[0].remark
    assert proof.findings[0].trace is None


def test_what_no_query_says() -> None:
    lost = "P: a -> b; sync: go! | b -> a; guard: x > 3 && x < 3; do: x = 0 | b -> c; guard: n == 1"
    proof = prove(network("clock x; int[0,1] n; broadcast chan go;", lost))
    assert failing(proof) == ["locations", "edges", "channels"]
    assert finding(proof, "locations").remark == "P.c"
    assert "P b → a" in finding(proof, "edges").remark


def test_a_value_of_a_type_has_one_name() -> None:
    walk = "P: a -> a; guard: x >= 1; do: x = 0, m = 1 - m"
    named = "typedef int[0,3] mode_t; const mode_t OFF = 0, ON = {}, LOW = 1; mode_t m;"
    times = "typedef int[0,9] ms_t; const ms_t LONG = 5, LATE = 5;"  # no variable: no names of its values
    assert prove(network(f"clock x; {named.format(2)} {times}", walk)).holds
    found = finding(prove(network(f"clock x; {named.format(1)} {times}", walk)), "names")
    assert not found.holds
    assert found.remark == "ON and LOW are both 1 (mode_t)"


def test_time_that_stops_and_time_that_need_not_pass_come_with_a_run() -> None:
    stuck = "P: b: x <= 3 | a -> b; guard: x >= 1 | b -> a; guard: x <= 2; do: x = 0"
    found = finding(prove(network("clock x;", stuck)), "time")
    assert not found.holds
    assert found.remark == "no transition is possible, and time cannot go on"
    assert found.trace is not None
    quick = "P: a -> b; guard: x >= 1; do: x = 0 | b -> a | a -> b"
    found = finding(prove(network("clock x;", quick)), "time")
    assert not found.holds
    assert found.trace.loop is not None


def test_a_deadlock_that_only_widening_has_is_not_reported() -> None:
    # See test_traps: ExtraLU+ lets x be 3 in b, where b would be stuck.
    template = "P: a: x <= 2 | urgent: b | a -> b | b -> a; guard: x <= 2; do: x = 0"
    proof = prove(network("clock x;", template, queries=[("A[] not deadlock", "[alive]")]))
    assert finding(proof, "alive").holds


@pytest.mark.timeout(3600 if NIGHTLY else 120)
@settings(
    max_examples=examples(20, 2000), deadline=None, suppress_health_check=list(HealthCheck), phases=PHASES
)
@given(networks(), conditions(1))
def test_every_verdict_is_that_of_the_naive_explorer(model: Network, p: Condition) -> None:
    note(model.document.source.decode().replace("<", "\n<"))
    regions = Regions(model, LARGEST)
    reachable = regions.reachable()
    stuck = any(map(regions.deadlocked, reachable))
    asked = [("A[] not deadlock", not stuck), (f"A[] {p}", all(map(p.holds, reachable)))]
    asked.append((f"E<> deadlock && ({p})", any(p.holds(r) and regions.deadlocked(r) for r in reachable)))
    proof = proved(model, [text for text, _ in asked])
    for each, (text, expected) in zip(proof.findings, asked, strict=False):
        assert each.holds is expected, text
    stops = any(regions.deadlocked(region) and not endless(regions, region) for region in reachable)
    assert ("time cannot go on" in finding(proof, "time").remark) is stops


def endless(regions: Regions, region: Region) -> bool:
    """Whether time can pass for ever."""
    while (later := regions.later(region)) is not None:
        if later == region:
            return True
        region = later
    return False


def proved(model: Network, texts: list[str]) -> Proof:
    """The proof of a network, asked something else than what stands in its file."""
    requirements = tuple(Requirement(f"q{at}", text, parse_query(text)) for at, text in enumerate(texts))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(proving, "stored_requirements", lambda _: requirements)
        return prove(model)


def test_two_queries_of_one_name_are_refused() -> None:
    with pytest.raises(ModelError, match=r"Two queries are named \[lit\]"):
        prove(lamp(("E<> Lamp.on", "[lit] One."), ("E<> Lamp.off", "[lit] Two.")))


def test_progress_is_told() -> None:
    told: list[tuple[str, int]] = []
    counts = "P: a: x <= 1 | a -> a; guard: x >= 1; do: n = (n + 1) % 3000, x = 0"
    model = network("clock x; int[0,2999] n;", counts, queries=[("A[] n < 2900", "[few]")])
    begun = process_time()
    prove(model, lambda what, states: told.append((what, states)))
    assert ("all requirements", 1000) in told
    assert ("the shortest runs", 2000) in told
    assert process_time() - begun < 30


def test_what_a_file_can_do_with_its_own_constants_is_explored_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of each edit of it again: an edge that is dead there is dead."""
    explored: list[Network] = []

    def count(network: Network, *others: Any) -> Overview:
        explored.append(network)
        return overview(network, *others)

    monkeypatch.setattr(checking, "overview", count)
    monkeypatch.setattr(checking, "_KEPT", {})
    more = "Steps: a -> b; guard: i < N; do: i = i + 1 | b -> a"
    file = network("const int N = 1; int[0, 9] i = 0;", more).document
    for number in (0, -1, -2):
        assert finding(prove(make_network(file, {"N": number})), "edges").holds
    assert len(explored) == 1
    dead = network("const int N = 0; int[0, 9] i = 0;", more).document
    assert not finding(prove(make_network(dead, {"N": -1})), "edges").holds
    assert len(explored) == 2
