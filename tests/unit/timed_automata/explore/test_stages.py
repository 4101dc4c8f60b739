"""What a search may forget: stages are left for good, on random networks and where it can be counted."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, note, settings

from tests.support.nightly import NIGHTLY, PHASES, examples
from tests.unit.timed_automata.explore.models import Template, network
from tests.unit.timed_automata.explore.random_networks import networks
from timed_automata import Network
from timed_automata.explore.search import Search
from timed_automata.explore.search._reach import WidestFirst
from timed_automata.explore.search._stages import Stage, Stages
from timed_automata.explore.states import DiscreteSpace, SymbolicSpace
from timed_automata.explore.zones import Limits

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
    counts = Template(
        "P",
        [
            "a -> b; guard: chosen == 0; do: chosen = 1",
            "a -> b; guard: chosen == 0; do: chosen = 2",
            "a -> b; guard: chosen == 0; do: chosen = 3",
            "b -> b; guard: x >= 1; do: x = 0, i = i < 4 ? i + 1 : 0",
        ],
        locations="a b",
    )
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
