"""What is watched of the executed automata: their requirements, and the coverage of locations, edges and faults."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from end_effector_hal.control import network_of
from end_effector_hal.description import Description
from end_effector_lab.testbench import offered_faults
from timed_automata.execute import Observation, Step
from timed_automata.explore.properties import Coverage
from timed_automata.monitor import Monitor
from timed_automata.network import Edge, Process

NONE = "nominal"


class CoverageMap:
    """Everything that can be reached, by number: the drawn edges of each executed process.

    Edges that the constants of the description switch off are left out, as `eehal verify` leaves them out.

    Attributes:
        edges: names, such as ``Gripper Step → Gripped``, with the place in the file.
        locations: names, such as ``Gripper.Step``.
        faults: names of the faults that the tool can have, after ``nominal``.
    """

    def __init__(self, description: Description) -> None:
        network, automata = network_of(description), description.automata
        executed = set(automata.executed)
        processes = [each for each in network.processes if executed & {each.name, each.template}]
        off = Coverage().report(network).disabled
        names: dict[str, int] = {}
        self._edges: dict[tuple[str, int], int] = {}
        places: dict[str, int] = {}
        self._places: dict[tuple[str, str], int] = {}
        for process in processes:
            kept = [edge for edge in process.edges if not _is_off(edge, off)]
            for edge in kept:
                self._edges[process.name, edge.index] = names.setdefault(_name(process, edge), len(names))
            for at in sorted({at for edge in kept for at in (edge.source, edge.target)}):
                name = process.locations[at].name
                self._places[process.name, name] = places.setdefault(f"{process.name}.{name}", len(places))
        begun = [(each.name, each.locations[each.initial].name) for each in processes]
        self.initial = frozenset(self._places[place] for place in begun if place in self._places)
        self.edges, self.locations = tuple(names), tuple(places)
        offered = [each.name for each in offered_faults(description)]
        self.faults = (NONE, *(each for each in offered if each != NONE))

    def pair(self, edge: int, fault: int) -> int:
        """Return the number of an edge combined with a fault."""
        return edge * len(self.faults) + fault

    def edge(self, process: str, index: int) -> int | None:
        """Return the number of an edge; None: it is not counted."""
        return self._edges.get((process, index))

    def location(self, process: str, name: str) -> int | None:
        """Return the number of a location; None: it is not counted."""
        return self._places.get((process, name))


def _is_off(edge: Edge, off: Iterable[str]) -> bool:
    return any(each.startswith(f"{edge.span.where}: ") for each in off)


def _name(process: Process, edge: Edge) -> str:
    names = " → ".join(process.locations[at].name for at in (edge.source, edge.target))
    line = edge.span.where.split(":")
    labels = [
        " ".join(edge.drawn.labels[kind].text.content.split())
        for kind in ("guard", "synchronisation")
        if kind in edge.drawn.labels
    ]
    said = f" ({', '.join(labels)})" if labels else ""
    return (
        f"{process.name} {names}{said}, line {line[-2]}" if len(line) > 2 else f"{process.name} {names}{said}"
    )


@dataclass
class Reached:
    """The reached edges, locations and pairs, as numbers of a `CoverageMap`."""

    edges: set[int] = field(default_factory=set)
    locations: set[int] = field(default_factory=set)
    pairs: set[int] = field(default_factory=set)

    def beyond(self, other: Reached) -> Reached:
        """Return the part that another result has not reached."""
        return Reached(
            edges=self.edges - other.edges,
            locations=self.locations - other.locations,
            pairs=self.pairs - other.pairs,
        )

    def add(self, other: Reached) -> None:
        """Add another result."""
        self.edges |= other.edges
        self.locations |= other.locations
        self.pairs |= other.pairs

    def __bool__(self) -> bool:
        return bool(self.edges or self.locations or self.pairs)

    def as_json(self) -> dict[str, list[int]]:
        """Return the numbers, sorted."""
        return {name: sorted(numbers) for name, numbers in vars(self).items()}


class Coverer:
    """Records the coverage of a run; ``faults`` are the numbers of the present faults."""

    def __init__(self, known: CoverageMap) -> None:
        self._map = known
        self.faults: tuple[int, ...] = (0,)
        self.reached = Reached(locations=set(known.initial))

    def suffer(self, scenario: str) -> None:
        """Set the present scenario of the testbench."""
        names = [part.strip().partition(":")[0] for part in scenario.split(",")]
        self.faults = tuple(self._map.faults.index(name) for name in names if name in self._map.faults)

    def watch(self) -> Callable[[Observation], None]:
        """Return the `Watch` function for a `VirtualTool`."""
        return self._note

    def _note(self, observation: Observation) -> None:
        if not isinstance(observation, Step):
            return
        for taken in observation.edges:
            if (edge := self._map.edge(taken.process, taken.index)) is not None:
                self.reached.edges.add(edge)
                self.reached.pairs.update(self._map.pair(edge, fault) for fault in self.faults)
            if (place := self._map.location(taken.process, taken.target)) is not None:
                self.reached.locations.add(place)


class Monitors:
    """Creates a monitor for each new controller, with the requirements of the automata."""

    def __init__(self, description: Description) -> None:
        self._automata, self._network = description.automata, network_of(description)
        self._monitors: list[Monitor] = []

    def watch(self) -> Callable[[Observation], None]:
        """Create a monitor for a controller; return the function that receives its observations."""
        automata = self._automata
        monitor = Monitor(self._network, automata.executed, automata.interface, requirements=True)
        self._monitors.append(monitor)
        return monitor.observe

    @property
    def objections(self) -> list[str]:
        """The objections of all monitors, as sentences."""
        return [each.what for monitor in self._monitors for each in monitor.objections]
