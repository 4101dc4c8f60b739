"""The layout of a template in UPPAAL's pixels: coordinates of its file or defaults, and its edges as arrows."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import cos, hypot, pi, sin

from timed_automata import DrawnEdge, DrawnLocation, Label, Template

from ._labels import Box, width_of
from ._style import plain

Spot = tuple[float, float]

RADIUS = 11.0  # of a location
HEAD, HEAD_HALF = 10.0, 3.6  # length of the tip of an arrow, and half its width
_CORNER = 22.0
_LOOP = ((-34.0, -46.0), (34.0, -46.0))  # nails of a loop that has none


@dataclass(frozen=True)
class Arrow:
    """The corners of an edge; the first and the last are on the rims of its locations."""

    corners: tuple[Spot, ...]

    @property
    def segments(self) -> tuple[tuple[Spot, Spot], ...]:
        return tuple(zip(self.corners, self.corners[1:], strict=False))

    @property
    def middle(self) -> Spot:
        left = sum(_length(a, b) for a, b in self.segments) / 2
        for a, b in self.segments:
            length = _length(a, b)
            if length and left <= length:
                return _towards(a, b, left)
            left -= length
        return self.corners[0]

    def rounded(self) -> list[tuple[Spot, Spot, Spot]]:
        """Return, for each inner corner: the start of the curve, the corner, the end of the curve."""
        curves = []
        for before, corner, after in zip(self.corners, self.corners[1:], self.corners[2:], strict=False):
            cut = min(_CORNER, _length(before, corner) / 2, _length(corner, after) / 2)
            curves.append((_towards(corner, before, cut), corner, _towards(corner, after, cut)))
        return curves

    @property
    def tip(self) -> tuple[Spot, Spot, Spot]:
        """The triangle at the arrow's end, the point first."""
        before, end = self.corners[-2], self.corners[-1]
        length = _length(before, end) or 1.0
        along = ((end[0] - before[0]) / length, (end[1] - before[1]) / length)
        base = (end[0] - HEAD * along[0], end[1] - HEAD * along[1])
        aside = (-along[1] * HEAD_HALF, along[0] * HEAD_HALF)
        return end, (base[0] + aside[0], base[1] + aside[1]), (base[0] - aside[0], base[1] - aside[1])


def arrow_between(source: Spot, nails: list[Spot], target: Spot) -> Arrow:
    if not nails and source == target:
        nails = [(source[0] + x, source[1] + y) for x, y in _LOOP]
    way = [spot for spot, before in zip([*nails, target], [source, *nails], strict=True) if spot != before]
    way = [source, *way] if way else [source, target]
    start, end = _towards(way[0], way[1], RADIUS), _towards(way[-1], way[-2], RADIUS)
    return Arrow((start, *way[1:-1], end))


def _length(a: Spot, b: Spot) -> float:
    return hypot(b[0] - a[0], b[1] - a[1])


def _towards(a: Spot, b: Spot, distance: float) -> Spot:
    length = _length(a, b) or 1.0
    return a[0] + (b[0] - a[0]) * distance / length, a[1] + (b[1] - a[1]) * distance / length


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
