"""Cycles of a directed graph."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from typing import TypeVar

N = TypeVar("N", bound=Hashable)
L = TypeVar("L")


def components(graph: Mapping[N, Sequence[N]]) -> list[list[N]]:
    """Return the strongly connected components that contain a cycle."""
    return [found for found in strong(graph) if len(found) > 1 or found[0] in graph[found[0]]]


def strong(graph: Mapping[N, Sequence[N]]) -> Iterator[list[N]]:
    """Yield all strongly connected components, successors first (Tarjan 1972, without recursion)."""
    order: dict[N, int] = {}
    low: dict[N, int] = {}
    stack: list[N] = []
    on_stack: set[N] = set()
    for root in graph:
        if root in order:
            continue
        order[root] = low[root] = len(order)
        stack.append(root)
        on_stack.add(root)
        work = [(root, iter(graph[root]))]
        while work:
            node, following = work[-1]
            for other in following:
                if other not in order:
                    order[other] = low[other] = len(order)
                    stack.append(other)
                    on_stack.add(other)
                    work.append((other, iter(graph[other])))
                    break
                if other in on_stack:
                    low[node] = min(low[node], order[other])
            else:
                work.pop()
                if work:
                    parent = work[-1][0]
                    low[parent] = min(low[parent], low[node])
                if low[node] == order[node]:
                    component: list[N] = []
                    while not component or component[-1] != node:
                        component.append(stack.pop())
                        on_stack.discard(component[-1])
                    yield component


def shortest_cycle(start: N, following: Callable[[N], Iterable[tuple[L, N]]]) -> list[L]:
    """Return the labels of the edges of a shortest cycle through a node that is on a cycle."""
    came: dict[N, tuple[N, L]] = {}
    waiting = deque([start])
    while start not in came:
        at = waiting.popleft()
        for label, other in following(at):
            if other not in came:
                came[other] = (at, label)
                waiting.append(other)
    at, label = came[start]
    labels = [label]
    while at != start:
        at, label = came[at]
        labels.append(label)
    return labels[::-1]
