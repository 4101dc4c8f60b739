"""Text placement without overlaps, also beside a plot; everything in inches."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

from matplotlib.axes import Axes
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path

Point = tuple[float, float]

_HINTING = 1.04
"""Factor by which rendered text may be wider than its outlines."""


@lru_cache(maxsize=4096)
def width_of(text: str, size: float, weight: str = "normal") -> float:
    """Return the width of a line of text, inches."""
    font = FontProperties(family="DejaVu Sans", size=size, weight=weight)
    width, _, _ = text_to_path.get_text_width_height_descent(text, font, ismath=False)
    return float(width) / 72 * _HINTING


def height_of(size: float) -> float:
    """Return the height of a line of text, inches."""
    return size / 72 * 1.25


@dataclass(frozen=True)
class Box:
    """A rectangle; y may point either way, as long as ``y0 <= y1``."""

    x0: float
    y0: float
    x1: float
    y1: float

    def meets(self, other: Box) -> bool:
        return self.x0 < other.x1 and other.x0 < self.x1 and self.y0 < other.y1 and other.y0 < self.y1

    def meets_line(self, start: Point, end: Point) -> bool:
        """Return whether a straight line passes through (Liang and Barsky's clipping)."""
        enter, leave = 0.0, 1.0
        for low, high, a, b in ((self.x0, self.x1, start[0], end[0]), (self.y0, self.y1, start[1], end[1])):
            step = b - a
            if step == 0:
                if not low < a < high:
                    return False
                continue
            first, last = sorted(((low - a) / step, (high - a) / step))
            enter, leave = max(enter, first), min(leave, last)
        return enter < leave

    def within(self, outer: Box) -> bool:
        return outer.x0 <= self.x0 and self.x1 <= outer.x1 and outer.y0 <= self.y0 and self.y1 <= outer.y1


class Sheet:
    """The occupied places: boxes, and lines that text must not cover.

    Places are indexed by the columns of the page, and a line equal to another within a hundredth of an inch is not
    stored: the effort grows with the page, not with the length of the recording.
    """

    _COLUMN_IN = 0.4

    def __init__(self) -> None:
        self._boxes: dict[int, list[Box]] = {}
        self._lines: dict[int, dict[tuple[int, ...], tuple[Point, Point]]] = {}

    def _columns(self, x0: float, x1: float) -> range:
        low, high = (x0, x1) if x0 < x1 else (x1, x0)
        return range(int(low // self._COLUMN_IN), int(high // self._COLUMN_IN) + 1)

    def free(self, box: Box) -> bool:
        columns = self._columns(box.x0, box.x1)
        if any(box.meets(other) for column in columns for other in self._boxes.get(column, ())):
            return False
        return not any(
            box.meets_line(*line) for column in columns for line in self._lines.get(column, {}).values()
        )

    def free_line(self, start: Point, end: Point) -> bool:
        """Return whether a line would cross no text."""
        columns = self._columns(start[0], end[0])
        return not any(
            box.meets_line(start, end) for column in columns for box in self._boxes.get(column, ())
        )

    def crosses(self, start: Point, end: Point) -> bool:
        """Return whether a line would cross another; touching an end does not count."""
        columns = self._columns(start[0], end[0])
        return any(_cross(start, end, *line) for c in columns for line in self._lines.get(c, {}).values())

    def take(self, box: Box) -> None:
        for column in self._columns(box.x0, box.x1):
            self._boxes.setdefault(column, []).append(box)

    def take_line(self, start: Point, end: Point) -> None:
        key = tuple(round(value * 100) for value in (*start, *end))
        for column in self._columns(start[0], end[0]):
            self._lines.setdefault(column, {}).setdefault(key, (start, end))


def _cross(a: Point, b: Point, c: Point, d: Point) -> bool:
    def side(p: Point, q: Point, r: Point) -> float:
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    return side(a, b, c) * side(a, b, d) < -1e-9 and side(c, d, a) * side(c, d, b) < -1e-9


def spread(wanted: Sequence[float], heights: Sequence[float], low: float, high: float) -> list[float]:
    """Return centres near the wanted ones for items stacked between two bounds without overlap.

    If not all of them fit, they start at ``low`` and pass ``high``.
    """
    order = sorted(range(len(wanted)), key=lambda index: wanted[index])
    centres = list(wanted)
    edge = low
    for index in order:
        centres[index] = max(centres[index], edge + heights[index] / 2)
        edge = centres[index] + heights[index] / 2
    edge = max(high, low + sum(heights))
    for index in reversed(order):
        centres[index] = min(centres[index], edge - heights[index] / 2)
        edge = centres[index] - heights[index] / 2
    return centres


def wrapped(text: str, size: float, weight: str, width: float) -> list[str]:
    """Return the text in lines no wider than ``width``; a single word may be wider."""
    return packed(text.split(), " ", size, weight, width)


def packed(parts: Iterable[str], between: str, size: float, weight: str, width: float) -> list[str]:
    """Join parts with ``between`` into lines no wider than ``width``; a single part may be wider."""
    lines: list[str] = []
    for part in parts:
        longer = f"{lines[-1]}{between}{part}" if lines else part
        if lines and width_of(longer, size, weight) <= width:
            lines[-1] = longer
        else:
            lines.append(part)
    return lines


def first_fitting(texts: Iterable[str], size: float, width: float) -> str | None:
    """Return the first text that fits into a width."""
    return next((text for text in texts if width_of(text, size) <= width), None)


BESIDE_SIZE = 9.0
"""Size of this text, points."""


def write_beside(axes: Axes, labels: Sequence[tuple[float, str, str]], height_in: float) -> None:
    """Write ``(value, text, colour)`` beside the plot, whose limits are set; a text may have several lines.

    Args:
        axes: the plot.
        labels: the texts, at values of the plot's y axis.
        height_in: height of the plot, inches.
    """
    low, high = axes.get_ylim()
    heights = [
        height_of(BESIDE_SIZE) * (text.count("\n") + 1) * (high - low) / height_in for _, text, _ in labels
    ]
    places = spread([at for at, _, _ in labels], heights, low, high)
    for place, (_, text, colour) in zip(places, labels, strict=True):
        axes.annotate(
            text,
            (1.0, place),
            xycoords=("axes fraction", "data"),
            xytext=(6, 0),
            textcoords="offset points",
            color=colour,
            fontsize=BESIDE_SIZE,
            va="center",
            linespacing=1.15,
            annotation_clip=False,
        )
