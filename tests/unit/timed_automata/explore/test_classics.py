"""Published models with known results."""

from __future__ import annotations

import pytest

from tests.support.nightly import NIGHTLY
from tests.unit.timed_automata.explore.classics import bridge, csma_cd, doors, fischer, train_gate
from tests.unit.timed_automata.explore.sanity import sanity_check
from timed_automata.explore import Explorer, verify

EXCLUSION = "A[] forall (i : pid_t) forall (j : pid_t) P(i).cs && P(j).cs imply i == j"


MOST = 7 if NIGHTLY else 5


@pytest.mark.parametrize("n", range(2, MOST + 1))
def test_fischer_excludes(n: int) -> None:
    explorer = Explorer(fischer(n))
    assert explorer.check(EXCLUSION).holds
    assert explorer.check("A[] not deadlock").holds
    assert explorer.check("E<> P(1).cs").holds
    assert explorer.check("E<> P(2).cs").holds


@pytest.mark.parametrize("n", range(2, MOST + 1))
@pytest.mark.parametrize("wait", ["x >= 2", "x > 1", "true"])
def test_fischer_that_waits_too_short(n: int, wait: str) -> None:
    verdict = verify(fischer(n, wait=wait), EXCLUSION)
    assert not verdict.holds
    assert sum(process == 3 for process in verdict.trace.steps[-1].state.locations) == 2
    assert len(verdict.trace.steps) == 6  # both ask, one writes and enters, the other does


def test_limits_by_location_keep_fischer_small() -> None:
    states = [verify(fischer(n), EXCLUSION).states for n in (2, 3, 4, 5)]
    assert states == [18, 71, 282, 1100]  # 6: 4140; by global limits it would be 81,214


def test_fischer_is_not_live() -> None:
    explorer = Explorer(fischer(2))
    assert not explorer.check("P(1).req --> P(1).cs").holds
    assert explorer.check("P(1).req --> P(1).wait").holds
    assert explorer.check("sup{P(1).req}: P(1).x").extremes[0].value == 2
    entered = explorer.check("inf{P(1).cs}: P(1).x").extremes[0]
    assert (entered.value, entered.attained) == (2, False)


@pytest.mark.parametrize("n", [2, 3])
def test_train_gate(n: int) -> None:
    explorer = Explorer(train_gate(n))
    assert explorer.check(
        "A[] forall (i : id_t) forall (j : id_t) Train(i).Cross && Train(j).Cross imply i == j"
    ).holds
    assert explorer.check("A[] not deadlock").holds
    assert explorer.check("A[] list[N] == 0").holds
    assert explorer.check("E<> Train(0).Cross && (forall (i : id_t) i != 0 imply Train(i).Stop)").holds
    assert explorer.check("Train(0).Appr --> Train(0).Cross").holds
    assert sanity_check(explorer.network).ok


def test_train_gate_that_lets_trains_stand_on_the_bridge_is_live_no_more() -> None:
    network = train_gate(2, leave="x >= 3 && x <= 2")
    explorer = Explorer(network)
    assert explorer.check("A[] not (Train(0).Cross && Train(1).Cross)").holds
    assert not explorer.check("A[] not deadlock").holds
    survey = sanity_check(explorer.network)
    assert survey.timelock is not None
    assert any("Cross → Safe" in edge for edge in survey.coverage.edges)


def test_bridge_takes_an_hour() -> None:
    explorer = Explorer(bridge())
    safe = "A.there && B.there && C.there && D.there"
    assert explorer.check(f"inf{{{safe}}}: time").extremes[0].value == 60
    assert explorer.check(f"E<> {safe} && time <= 60").holds
    assert not explorer.check(f"E<> {safe} && time < 60").holds
    first = explorer.check(f"E<> {safe} && time <= 60").trace
    assert first.end == 60


def test_doors() -> None:
    explorer = Explorer(doors())
    assert explorer.check("A[] not (Door(0).open && Door(1).open)").holds
    assert explorer.check("E<> Door(0).open").holds
    assert explorer.check("A[] not deadlock").holds
    assert (
        explorer.check("Door(0).waiting --> Door(0).open").holds is False
    )  # the other may be faster, for ever
    assert verify(doors(), "sup{Door(0).open}: Door(0).x").extremes[0].value == 8


def test_csma_cd_collisions_are_heard() -> None:
    explorer = Explorer(csma_cd(2))
    assert explorer.check("A[] S(1).send && S(2).send imply S(1).x < 52").holds
    assert not explorer.check("A[] S(1).send && S(2).send imply S(1).x < 51").holds
    assert explorer.check("E<> S(1).send && S(1).x == 808").holds
    assert explorer.check("A[] not deadlock").holds
    assert [
        edge.split(": ")[1] for edge in sanity_check(explorer.network).coverage.edges
    ] == [  # two can only collide while sending
        "S wait → wait (cd?)",
        "S wait → retry (cd?)",
        "S retry → retry (cd?)",
    ]
    assert not sanity_check(csma_cd(3)).coverage.edges
