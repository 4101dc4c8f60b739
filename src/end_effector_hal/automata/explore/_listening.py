"""The semantics, faster where there are many processes: only those that ever listen to a channel are asked."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from end_effector_hal.automata._constraints import Bound
from end_effector_hal.automata._network import Edge, Network, State
from end_effector_hal.automata._semantics import Semantics


class ListeningSemantics(Semantics):
    """Gives the same transitions in the same order (a test holds it against its base)."""

    def __init__(self, network: Network) -> None:
        super().__init__(network)
        self._broadcast = [channel.broadcast for channel in network.channels]
        self._listeners: list[list[int]] = [[] for _ in network.channels]
        for process in network.processes:
            heard = {c for edge in process.edges if edge.direction == "?" for c in edge.channels}
            for channel in sorted(heard):
                self._listeners[channel].append(process.index)

    def _receivers(
        self, state: State, channel: int, sender: int | None
    ) -> Iterator[tuple[tuple[Edge, ...], tuple[Bound, ...]]]:
        locations, values = state
        choices = []
        for process in self._listeners[channel]:
            if process != sender:
                enabled = self._leaving[process][locations[process]].receivers(channel, values)
                if enabled:
                    choices.append(enabled)
        if not self._broadcast[channel]:
            for enabled in choices:
                for edge, bounds in enabled:
                    yield (edge,), bounds
        elif not choices:
            yield (), ()
        else:
            for choice in product(*choices):
                yield tuple(edge for edge, _ in choice), tuple(b for _, bounds in choice for b in bounds)
