"""Where the edges of recorded steps stand: in the UPPAAL file that the trace holds, at the place that is recorded."""

from __future__ import annotations

from collections.abc import Iterator

from timed_automata import Network, Step
from timed_automata.monitor import Objection


class EdgePlaces:
    """Holds the recorded places of edges against the file.

    Args:
        network: of the file in the trace.
    """

    def __init__(self, network: Network) -> None:
        self._edges = {process.name: process.edges for process in network.processes}
        self._path: str | None = None

    def step(self, step: Step) -> Iterator[Objection]:
        """The path is that of the machine that recorded it: it must be the same in all steps."""
        for taken in step.edges:
            edges = self._edges.get(taken.process, ())
            if not 0 <= taken.index < len(edges):
                continue  # the monitor says so
            path, place = _parted(taken.where)
            _, there = _parted(edges[taken.index].span.where)
            self._path = path if self._path is None else self._path
            who = f"{taken.process} {taken.source} → {taken.target}"
            if place != there:
                what = f"{who} is recorded as standing at {place}, and stands at {there}."
                yield Objection(step.at, "no run", what)
            elif path != self._path:
                what = f"{who} is recorded as standing in {path!r}, and others in {self._path!r}."
                yield Objection(step.at, "no run", what)


def _parted(where: str) -> tuple[str, str]:
    """The path, and ``line:column``."""
    path, line, column = (["", "", *where.rsplit(":", 2)])[-3:]
    return path, f"{line}:{column}"
