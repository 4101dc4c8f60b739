"""Edges as lines through their nails, from rim to rim, with rounded corners."""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot

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
