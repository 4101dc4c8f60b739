"""Whatever the network and the query: a run that refutes it has its explanation, which fits the run."""

from __future__ import annotations

from hypothesis import HealthCheck, given, settings

from tests.support.nightly import PHASES, examples
from tests.unit.timed_automata.explore.random_networks import Condition, conditions, networks
from timed_automata import Network
from timed_automata.explain import Names, WatchedClock, explain
from timed_automata.explore import Explorer
from timed_automata.queries import parse_query

many = settings(
    max_examples=examples(20, 2000), deadline=None, suppress_health_check=list(HealthCheck), phases=PHASES
)


@many
@given(networks(), conditions(), conditions(1))
def test_what_refutes_is_explained(network: Network, p: Condition, q: Condition) -> None:
    for text in (
        f"A[] !({p})",
        f"A[] ({p}) imply {q}",
        f"A[] !deadlock || ({p})",
        f"A<> {p}",
        f"{p} --> {q}",
    ):
        trace = Explorer(network).check(text).trace
        if trace is None:
            continue
        found = explain(trace, parse_query(text), Names(network))
        assert found.sentence.endswith(".")
        assert any(each.wrong for each in found.watched)
        state = trace.steps[-1].state if trace.steps else network.initial
        shown = {
            process.name: process.locations[state.locations[process.index]].name
            for process in network.processes
        }
        shown["i"] = str(state.values[network.offset("i")])
        for each in found.watched:
            if isinstance(each, WatchedClock):
                assert each.points[-1][0] == trace.end
                assert all(
                    before[0] <= after[0] for before, after in zip(each.points, each.points[1:], strict=False)
                )
            else:
                assert each.changes[-1][1] == shown[each.name]
