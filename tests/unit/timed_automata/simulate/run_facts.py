"""Whether a run that was played is a run of its network, judged by the monitor."""

from __future__ import annotations

from timed_automata import Step, TakenEdge
from timed_automata.monitor import Monitor


def assert_is_run(trace):
    """Every step is allowed when it is taken, and leads to the state that it says."""
    network = trace.network
    monitor = Monitor(network)
    monitor.begin(0)
    for step in trace.steps:
        at = step.at * 1000
        monitor.observe(
            Step(at, None, 0, False, None, step.channel, _taken(network, step.edges), step.changes)
        )
        assert monitor.objections == []
        assert monitor.state == step.state
    assert monitor.steps == len(trace.steps)
    assert trace.end >= max([step.at for step in trace.steps], default=0)


def _taken(network, edges):
    taken = []
    for edge in edges:
        process = network.processes[edge.process]
        ends = (process.locations[edge.source].name, process.locations[edge.target].name)
        taken.append(TakenEdge(process.name, *ends, edge.index, ""))
    return tuple(taken)
