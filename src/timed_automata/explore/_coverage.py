"""What every model must satisfy, whatever its queries: all of it can happen, and time can always pass."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from timed_automata import DrawnEdge, Network, Process
from timed_automata.explore._concrete import concrete
from timed_automata.explore._deadlock import Deadlocks
from timed_automata.explore._divergence import taken, zeno_run
from timed_automata.explore._reach import Node, Search
from timed_automata.explore._symbolic import Place
from timed_automata.explore._trace import Trace
from timed_automata.explore._zeno import Taken
from timed_automata.explore._zone import Zone


@dataclass(frozen=True, slots=True)
class Coverage:
    """The findings; empty and None are good.

    Attributes:
        states: symbolic states that were stored.
        unreached: ``Template.location`` that no process of the template ever enters.
        idle: edges that no process of their template can ever take, as ``file:line:column: Template a → b``.
        open_channels: channels that are only sent on or only received on, in words.
        deadlock: a run to a state without any transition, now or later.
        timelock: a run to a deadlock in which time cannot go on either.
        zeno: a run to, and once round, a cycle on which no time needs to pass.
    """

    states: int
    unreached: tuple[str, ...]
    idle: tuple[str, ...]
    open_channels: tuple[str, ...]
    deadlock: Trace | None
    timelock: Trace | None
    zeno: Trace | None

    @property
    def diverges(self) -> bool:
        """Whether from every state time can pass without end, and does so in every infinite run."""
        return self.timelock is None and self.zeno is None

    @property
    def complete(self) -> bool:
        """Whether every edge can fire, every location can be reached, every channel has both ends."""
        return not (self.unreached or self.idle or self.open_channels)

    @property
    def ok(self) -> bool:
        """Nothing was found."""
        return self.complete and self.diverges and self.deadlock is None


class Survey:
    """One exploration of everything. ``search`` must have symmetric limits: deadlocks are looked for."""

    def __init__(self, search: Search) -> None:
        self.search, self.network = search, search.space.discrete.network
        self._deadlocks = Deadlocks()

    def run(self) -> Coverage:
        """Explore.

        Raises:
            OutOfRangeError: a value leaves its range on the way.
        """
        deadlock = timelock = None
        for node in self.search.nodes():
            if (deadlock is None or timelock is None) and self._deadlocks.of(node.place, node.zone):
                deadlock = deadlock or node
                discrete = node.place.discrete
                if not discrete.delays or discrete.invariant:
                    timelock = timelock or node
        arcs = list(taken(iter(self.search.space.places)))
        return Coverage(
            states=self.search.states,
            unreached=tuple(self._unreached()),
            idle=tuple(self._idle(arcs)),
            open_channels=tuple(open_channels(self.network)),
            deadlock=self._stuck(deadlock, "no transition is possible, now or later"),
            timelock=self._stuck(timelock, "no transition is possible, and time cannot go on"),
            zeno=zeno_run(self.search, arcs),
        )

    def _unreached(self) -> Iterator[str]:
        reached: set[tuple[str, int]] = set()
        for place in self.search.space.places:
            if place.passed:
                locations = zip(self.network.processes, place.discrete.stand.locations, strict=True)
                reached.update((process.template, at) for process, at in locations)
        for process in _one_of_each(self.network):
            for location in process.locations:
                if (process.template, location.index) not in reached:
                    yield f"{process.template}.{location.name}"

    def _idle(self, arcs: list[Taken]) -> Iterator[str]:
        fired = {id(edge.drawn) for label in {move.label for _, _, move in arcs} for edge in label.edges}
        for process in _one_of_each(self.network):
            told: set[int] = set()
            for edge in process.edges:
                if id(edge.drawn) not in fired | told:
                    told.add(id(edge.drawn))
                    names = [process.locations[at].name for at in (edge.source, edge.target)]
                    yield f"{edge.span.where}: {process.template} {' → '.join(names)}{_labels(edge.drawn)}"

    def _stuck(self, node: Node | None, remark: str) -> Trace | None:
        if node is None:
            return None

        def ending(place: Place, zone: Zone) -> Zone | None:
            return next(iter(self._deadlocks.of(place, zone)), None)

        return concrete(self.search.space, node.legs, ending, remark)


def _labels(edge: DrawnEdge) -> str:
    found = [edge.labels[kind].text.content for kind in ("guard", "synchronisation") if kind in edge.labels]
    return f" ({', '.join(' '.join(label.split()) for label in found)})" if found else ""


def _one_of_each(network: Network) -> Iterator[Process]:
    """A process of each template; edges are told apart by what was drawn, which all of its processes share."""
    seen: set[str] = set()
    for process in network.processes:
        if process.template not in seen:
            seen.add(process.template)
            yield process


def open_channels(network: Network) -> Iterator[str]:
    """Channels with one end only, or with none."""
    ends: dict[int, set[str]] = {number: set() for number in range(len(network.channels))}
    for process in network.processes:
        for edge in process.edges:
            for channel in edge.channels:
                ends[channel].add(edge.direction)
    for number, found in ends.items():
        if found != {"!", "?"}:
            missing = {frozenset("!"): "nobody receives on it", frozenset("?"): "nobody sends on it"}
            yield f"{network.channels[number].name}: {missing.get(frozenset(found), 'nobody uses it')}"
