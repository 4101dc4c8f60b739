"""Parts of a model that its constants switch off: they cannot happen, and are not expected to."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from typing import NamedTuple

from timed_automata.network import Edge, Network, Process

_WORD = re.compile(r"[A-Za-z_]\w*")


class DisabledParts(NamedTuple):
    """Edges by the ``id`` of what was drawn, which all processes of a template share; template and location."""

    edges: frozenset[int]
    locations: frozenset[tuple[str, int]]


def statically_disabled(network: Network) -> DisabledParts:
    """Edges whose guard the constants make false, and all that can only happen after such edges.

    A guard that is false and names no constant is no switch: what lies behind it is expected to happen.
    """
    every = [edge for process in network.processes for edge in process.edges]
    possible = {id(edge.drawn) for edge in every if not edge.guard.never}
    switches = {
        id(edge.drawn)
        for edge in every
        if id(edge.drawn) not in possible and _mentions(edge, network.constants.keys())
    }
    if not switches:
        return DisabledParts(frozenset(), frozenset())
    without, with_ = _dead(network, frozenset()), _dead(network, frozenset(switches))
    return DisabledParts(with_.edges - without.edges, with_.locations - without.locations)


def _mentions(edge: Edge, names: Collection[str]) -> bool:
    guard = edge.drawn.labels.get("guard")
    return guard is not None and not set(_WORD.findall(guard.text.content)).isdisjoint(names)


def _dead(network: Network, off: frozenset[int]) -> DisabledParts:
    """What no process can do without the edges that are off, by the graphs of the processes and by who sends."""
    while True:
        alive: set[int] = set()
        reached = {process.index: set(_reached(process, off)) for process in network.processes}
        edges = [
            edge
            for process in network.processes
            for edge in process.edges
            if edge.source in reached[process.index] and id(edge.drawn) not in off
        ]
        sent = {channel for edge in edges if edge.direction == "!" for channel in edge.channels}
        alive = {
            id(edge.drawn) for edge in edges if edge.direction != "?" or sent.intersection(edge.channels)
        }
        dead = frozenset({id(e.drawn) for p in network.processes for e in p.edges} - alive)
        if dead == off:
            break
        off = dead
    places = {(process.template, at) for process in network.processes for at in reached[process.index]}
    every = {(process.template, at) for process in network.processes for at in range(len(process.locations))}
    return DisabledParts(dead, frozenset(every - places))


def _reached(process: Process, off: frozenset[int]) -> Iterator[int]:
    """Locations that are connected to the initial one."""
    seen, waiting = {process.initial}, [process.initial]
    while waiting:
        at = waiting.pop()
        yield at
        for edge in process.edges:
            if edge.source == at and id(edge.drawn) not in off and edge.target not in seen:
                seen.add(edge.target)
                waiting.append(edge.target)
