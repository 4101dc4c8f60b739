"""Descriptions of steps and transitions in words."""

from __future__ import annotations

from collections.abc import Iterable

from timed_automata.execute import Step
from timed_automata.network import Change, Edge, Network, State, Transition

_LONGEST = 10**30


def same_edges(network: Network, transition: Transition, step: Step) -> bool:
    """Return whether a step names exactly the edges of this transition, by number and by locations."""
    ours = [_names(network, edge) for edge in transition.edges]
    return ours == [(edge.process, edge.source, edge.target, edge.index) for edge in step.edges]


def named(step: Step) -> str:
    """Return the edges of a step in words: ``Gripper Step → Reset with Actuator(1) Pending → Off``."""
    return " with ".join(f"{edge.process} {edge.source} → {edge.target}" for edge in step.edges)


def in_words(network: Network, edges: Iterable[Edge]) -> str:
    """Return edges of a network in the same words as `named`."""
    names = (_names(network, edge) for edge in edges)
    return " with ".join(f"{process} {source} → {target}" for process, source, target, _ in names)


def changes_in_words(changes: Iterable[Change]) -> str:
    """Return changes in words: ``ee 1 → 3, command 2 → -1``."""
    return ", ".join(f"{change.name} {change.old} → {change.new}" for change in changes) or "nothing"


def why_not(network: Network, state: State, step: Step) -> str:
    """Return the reason why a step cannot be taken in a state."""
    known = {process.name: process for process in network.processes}
    for taken in step.edges:
        process = known.get(taken.process)
        if process is None or not 0 <= taken.index < len(process.edges):
            return f"there is no edge {shortened(taken.index)} of {taken.process}"
        edge, here = process.edges[taken.index], state.locations[process.index]
        if here != edge.source:
            return f"{taken.process} is in {process.locations[here].name}"
        _, source, target, _ = _names(network, edge)
        if (taken.source, taken.target) != (source, target):
            return f"edge {taken.index} of {taken.process} leads from {source} to {target}"
    return "a guard or the synchronisation does not hold"


def shortened(number: int | None) -> str:
    """Return a recorded number as text; a very long one is not printed."""
    return str(number) if number is None or abs(number) < _LONGEST else "a number of many digits"


def _names(network: Network, edge: Edge) -> tuple[str, str, str, int]:
    process = network.processes[edge.process]
    source, target = process.locations[edge.source].name, process.locations[edge.target].name
    return process.name, source, target, edge.index
