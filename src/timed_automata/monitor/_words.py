"""Steps and transitions in words."""

from __future__ import annotations

from collections.abc import Iterable

from timed_automata.execute import Step
from timed_automata.network import Change, Edge, Network, State, Transition


def same_edges(network: Network, transition: Transition, step: Step) -> bool:
    """Whether a step took exactly this transition."""
    ours = [(network.processes[edge.process].name, edge.index) for edge in transition.edges]
    return ours == [(edge.process, edge.index) for edge in step.edges]


def named(step: Step) -> str:
    """``Gripper Step → Reset with Actuator(1) Pending → Off``."""
    return " with ".join(f"{edge.process} {edge.source} → {edge.target}" for edge in step.edges)


def in_words(network: Network, edges: Iterable[Edge]) -> str:
    """The same for the edges of a network."""
    parts = []
    for edge in edges:
        process = network.processes[edge.process]
        source, target = process.locations[edge.source].name, process.locations[edge.target].name
        parts.append(f"{process.name} {source} → {target}")
    return " with ".join(parts)


def changes_in_words(changes: Iterable[Change]) -> str:
    """``ee 1 → 3, command 2 → -1``."""
    return ", ".join(f"{change.name} {change.old} → {change.new}" for change in changes) or "nothing"


def why_not(network: Network, state: State, step: Step) -> str:
    """Why a step cannot be taken in a state."""
    known = {process.name: process for process in network.processes}
    for taken in step.edges:
        process = known.get(taken.process)
        if process is None or taken.index >= len(process.edges):
            return f"there is no edge {taken.index} of {taken.process}"
        here = state.locations[process.index]
        if here != process.edges[taken.index].source:
            return f"{taken.process} is in {process.locations[here].name}"
    return "a guard or the synchronisation does not hold"
