"""The executed automata as drawn in their file, and their present locations, last edges and clocks."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from end_effector_hal.control import Controller, model_constants
from end_effector_hal.description import Description
from end_effector_hal.verification.mutation import kept_record
from end_effector_hal.verification.proof import CHECKS, requirements_of
from timed_automata import DrawnEdge, DrawnLocation, ExecutionSnapshot, Label, Network, Step, Template

from ._log import in_file

_BOUND = re.compile(r"\b(?P<clock>[A-Za-z_]\w*)\s*<=?\s*(?P<bound>[^&|]+)")
_TERM = re.compile(r"(?P<number>\d+)|(?P<name>[A-Z]\w*)(?P<indices>(\[\w+\])*)")
_WRITTEN = re.compile(r"([A-Za-z_]\w*)(?:\[[^\]]*\])?\s*:?=(?!=)")
_AT_PLACES = ("invariant",)
_ON_EDGES = ("select", "guard", "synchronisation", "assignment", "comments")
_SPACING = 220


class AutomataView:
    """The drawing of the automata, and the present locations to highlight in it.

    Args:
        network: the automata; its document has the coordinates.
        description: the tool, which names the executed processes.
    """

    def __init__(self, network: Network, description: Description) -> None:
        executed = set(description.automata.executed)
        self._processes = [each for each in network.processes if {each.template, each.name} & executed]
        self._templates = {
            template.name.content.strip(): template
            for template in network.document.templates
            if template.name.content.strip() in {process.template for process in self._processes}
        }
        self._requirements = requirements_of(network)
        self._constants = model_constants(description)
        self._edges = {
            in_file(edge.place.where(0)): number
            for template in self._templates.values()
            for number, edge in enumerate(template.edges)
        }
        self._last: dict[str, dict[str, int]] = {}
        self._sequence = description.sequence

    def drawn(self) -> dict[str, Any]:
        """Return the templates with their coordinates, and their processes."""
        return {
            "templates": [
                _template(name, each, self._spoken_of(name, each), self._needed_by(each))
                for name, each in self._templates.items()
            ],
            "requirements": [
                *({"id": each.id, "sentence": each.sentence} for each in self._requirements),
                *({"id": id_, "sentence": sentence} for id_, sentence in CHECKS.items()),
            ],
            "processes": [
                {"name": process.name, "template": process.template, "who": self._who(process.name)}
                for process in self._processes
            ],
        }

    def step(self, step: Step) -> None:
        """Record the last edge of each process in a step."""
        for edge in step.edges:
            if (number := self._edges.get(in_file(edge.where))) is not None:
                self._last[edge.process] = {"edge": number, "at": step.at}

    def now(self, controller: Controller | None) -> dict[str, Any]:
        """Return by process: location, last edge, start times (µs) of its clocks, and their bounds (ms)."""
        if controller is None or (snapshot := controller.locations()) is None:
            return {}
        return {
            process.name: {
                "location": snapshot.locations[process.name],
                "last": self._last.get(process.name),
                "clocks": self._clocks(process.template, process.name, snapshot),
            }
            for process in self._processes
        }

    def _spoken_of(self, name: str, template: Template) -> list[list[int]]:
        """Return by edge the numbers of requirements that name one of its ends or a variable that it writes."""
        places = {each.id: _name(each) for each in template.locations}
        texts = [str(each.query) for each in self._requirements]
        found = []
        for edge in template.edges:
            ends = {re.escape(places[end]) for end in (edge.source, edge.target) if places[end]}
            label = edge.labels.get("assignment")
            written = set(_WRITTEN.findall(label.text.content)) if label else set()
            there = rf"\b{name}(?:\([^)]*\))?\.(?:{'|'.join(ends)})\b" if ends else "(?!)"
            word = re.compile("|".join([there, *(rf"\b{each}\b" for each in sorted(written))]))
            found.append([number for number, text in enumerate(texts) if word.search(text)])
        return found

    def _needed_by(self, template: Template) -> list[dict[str, Any]]:
        """Return by edge: how many edits were judged, and the numbers of the requirements that detected one."""
        numbers = {each: number for number, each in enumerate((*(r.id for r in self._requirements), *CHECKS))}
        found = [kept_record().of_edge(template, number) for number in range(len(template.edges))]
        return [
            {"edits": needs.edits, "by": [numbers[each] for each in needs.needed_by if each in numbers]}
            if needs
            else {"edits": 0, "by": []}
            for needs in found
        ]

    def _who(self, process: str) -> str:
        found = re.fullmatch(r"\w+\((\d+)\)", process)
        return self._sequence[int(found[1])] if found and int(found[1]) < len(self._sequence) else ""

    def _clocks(self, template: str, process: str, snapshot: ExecutionSnapshot) -> list[dict[str, Any]]:
        """Return the clocks that the invariant of the process's location bounds."""
        location, zeros = snapshot.locations[process], snapshot.zeros
        drawn = next((each for each in self._templates[template].locations if _name(each) == location), None)
        text = drawn.labels["invariant"].text.content if drawn and "invariant" in drawn.labels else ""
        clocks = []
        for found in _BOUND.finditer(text):
            clock = found["clock"]
            zero = zeros.get(f"{process}.{clock}", zeros.get(f"{template}.{clock}", zeros.get(clock)))
            if zero is not None:
                bound = found["bound"].strip()
                limit_ms = self._number(bound, process, snapshot.variables)
                clocks.append({"name": clock, "since": zero, "bound": bound, "limit_ms": limit_ms})
        return clocks

    def _number(self, bound: str, process: str, variables: Mapping[str, int]) -> int | None:
        """Return the value of a sum of constants and numbers, like ``T_CONFIRM[i] + D``; None for other texts."""
        total = 0
        for term in bound.split("+"):
            found = _TERM.fullmatch(term.strip())
            if found is None:
                return None
            value: Any = int(term) if found["number"] else self._constants.get(found["name"])
            for name in re.findall(r"\w+", found["indices"] or ""):
                index = variables.get(f"{process}.{name}", variables.get(name, -1))
                value = value[index] if isinstance(value, list) and 0 <= index < len(value) else None
            if not isinstance(value, int):
                return None
            total += value
        return total


def _name(location: DrawnLocation) -> str:
    return location.name.text.content.strip() if location.name else ""


def _template(
    name: str, template: Template, spoken_of: list[list[int]], needed_by: list[dict[str, Any]]
) -> dict[str, Any]:
    spots = _spots(template)
    numbers = {each.id: index for index, each in enumerate(template.locations)}
    return {
        "name": name,
        "locations": [
            {
                "name": _name(each),
                "x": spots[each.id][0],
                "y": spots[each.id][1],
                "initial": each.id == template.initial,
                "mark": "C" if each.committed else "U" if each.urgent else "",
                "labels": [
                    *_labels([each.name] if each.name else [], spots[each.id], -10, -34),
                    *_labels(
                        [each.labels[k] for k in _AT_PLACES if k in each.labels], spots[each.id], -10, 16
                    ),
                ],
            }
            for each in template.locations
        ],
        "edges": [
            _edge(each, spots, numbers) | {"requirements": spoken, "needed": needed}
            for each, spoken, needed in zip(template.edges, spoken_of, needed_by, strict=True)
        ],
    }


def _edge(
    edge: DrawnEdge, spots: Mapping[str, tuple[int, int]], numbers: Mapping[str, int]
) -> dict[str, Any]:
    way = [spots[edge.source], *((nail.x, nail.y) for nail in edge.nails), spots[edge.target]]
    middle = (
        way[len(way) // 2] if len(way) > 2 else ((way[0][0] + way[1][0]) // 2, (way[0][1] + way[1][1]) // 2)
    )
    labels = [edge.labels[kind] for kind in _ON_EDGES if kind in edge.labels]
    return {
        "source": numbers[edge.source],
        "target": numbers[edge.target],
        "way": way,
        "labels": _labels(labels, middle, 6, 0),
    }


def _labels(labels: list[Label], spot: tuple[int, int], dx: int, dy: int) -> list[dict[str, Any]]:
    found = []
    for label in labels:
        x, y = (label.at.x, label.at.y) if label.at else (spot[0] + dx, spot[1] + dy)
        lines = [line.expandtabs(4).rstrip() for line in label.text.content.strip("\n").split("\n")]
        found.append({"kind": label.kind, "x": x, "y": y, "lines": lines})
        dy += 15 * len(lines)
    return found


def _spots(template: Template) -> dict[str, tuple[int, int]]:
    """Return the locations' coordinates; locations without coordinates are placed in a row below the others."""
    known = {each.id: (each.at.x, each.at.y) for each in template.locations if each.at}
    below = max((y for _, y in known.values()), default=0) + _SPACING
    missing = [each.id for each in template.locations if not each.at]
    return known | {name: (number * _SPACING, below) for number, name in enumerate(missing)}
