"""The layout of a template: coordinates of its file, else readable defaults; in UPPAAL's pixels."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import cos, pi, sin

from end_effector_lab.figures._labels import Box, width_of
from end_effector_lab.figures._style import plain
from timed_automata import DrawnEdge, DrawnLocation, Label, Template

from ._arrow import RADIUS, Arrow, Spot, arrow_between

PX_PER_IN = 96
FONT_PX, LINE_PX = 12, 15
FONT_PT = FONT_PX * 72 / PX_PER_IN
_LONGEST = 10_000  # letters of a line

COLOURS = {
    "select": "#8f7400",
    "guard": "#16782f",
    "synchronisation": "#008391",
    "assignment": "#2438c8",
    "invariant": "#96249c",
    "name": "#7c2415",
    "comments": "#68727f",
}
"""Colour of each kind of label: UPPAAL's own, darkened for text on white."""

LEGEND = {
    "select": "select",
    "guard": "guard",
    "synchronisation": "synchronisation",
    "assignment": "update",
    "invariant": "invariant",
    "comments": "comment",
}


@dataclass(frozen=True)
class Words:
    """The lines of one label; ``x`` and ``y`` are its upper left corner."""

    kind: str
    lines: tuple[str, ...]
    x: float
    y: float

    @property
    def box(self) -> Box:
        width = max(width_of(line, FONT_PT) for line in self.lines) * PX_PER_IN
        return Box(self.x, self.y, self.x + width, self.y + LINE_PX * len(self.lines))

    def baseline(self, line: int) -> float:
        return self.y + LINE_PX * line + 12


def lines_of(text: str) -> tuple[str, ...]:
    return tuple(plain(line.expandtabs(4).rstrip(), _LONGEST) for line in text.strip("\n").split("\n"))


_ON_EDGES = ("select", "guard", "synchronisation", "assignment", "comments")
_SPACING = 220.0  # between locations that have no coordinates


@dataclass(frozen=True)
class Disc:
    """A location; ``mark`` is C, U or empty."""

    x: float
    y: float
    initial: bool
    mark: str
    fill: str

    @property
    def box(self) -> Box:
        return Box(self.x - RADIUS, self.y - RADIUS, self.x + RADIUS, self.y + RADIUS)


@dataclass(frozen=True)
class Layout:
    discs: tuple[Disc, ...]
    arrows: tuple[tuple[Arrow, str], ...]  # with their colour, or nothing
    words: tuple[Words, ...]

    @property
    def box(self) -> Box:
        boxes = [disc.box for disc in self.discs] + [words.box for words in self.words]
        spots = [spot for arrow, _ in self.arrows for spot in arrow.corners]
        boxes += [Box(x - 4, y - 4, x + 4, y + 4) for x, y in spots]
        return Box(
            min(box.x0 for box in boxes),
            min(box.y0 for box in boxes),
            max(box.x1 for box in boxes),
            max(box.y1 for box in boxes),
        )


def layout_of(template: Template) -> Layout:
    spots = _spots(template.locations)
    discs = tuple(
        Disc(*spots[each.id], each.id == template.initial, _mark(each), each.color or "")
        for each in template.locations
    )
    words = [word for each in template.locations for word in _location_words(each, spots[each.id])]
    arrows = []
    for edge in template.edges:
        nails = [(float(nail.x), float(nail.y)) for nail in edge.nails]
        arrow = arrow_between(spots[edge.source], nails, spots[edge.target])
        arrows.append((arrow, edge.color or ""))
        words += _edge_words(edge, arrow)
    return Layout(discs, tuple(arrows), tuple(words))


def _spots(locations: Iterable[DrawnLocation]) -> Mapping[str, Spot]:
    """Return the locations' coordinates; locations without coordinates are placed on a circle."""
    known = {each.id: (float(each.at.x), float(each.at.y)) for each in locations if each.at}
    missing = [each.id for each in locations if not each.at]
    radius = _SPACING * max(1, len(missing)) / (2 * pi)
    left = max((x for x, _ in known.values()), default=-_SPACING - radius) + _SPACING + radius
    for number, name in enumerate(missing):
        angle = 2 * pi * number / len(missing) - pi
        known[name] = (left + radius * cos(angle), radius * sin(angle))
    return known


def _mark(location: DrawnLocation) -> str:
    return "C" if location.committed else "U" if location.urgent else ""


def _location_words(location: DrawnLocation, spot: Spot) -> list[Words]:
    x, y = spot
    words = [_words("name", location.name, (x - 10, y - 34))] if location.name else []
    below = y + 16
    for kind in ("invariant", "comments"):
        if kind in location.labels:
            words.append(_words(kind, location.labels[kind], (x - 10, below)))
            below += LINE_PX * len(words[-1].lines)
    return words


def _edge_words(edge: DrawnEdge, arrow: Arrow) -> list[Words]:
    words: list[Words] = []
    x, y = arrow.middle
    for kind in _ON_EDGES:
        if kind in edge.labels:
            words.append(_words(kind, edge.labels[kind], (x + 6, y)))
            y += LINE_PX * len(words[-1].lines)
    return words


def _words(kind: str, label: Label, otherwise: Spot) -> Words:
    x, y = (label.at.x, label.at.y) if label.at else otherwise
    return Words(kind, lines_of(label.text.content), x, y)
