"""Functions that draw a template as in Fig. 5 of the paper."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, PathPatch, Polygon
from matplotlib.path import Path

from end_effector_hal.errors import UsageError
from timed_automata import Template

from ._automaton_layout import (
    COLOURS,
    FONT_PT,
    LEGEND,
    LINE_PX,
    PX_PER_IN,
    RADIUS,
    Arrow,
    Disc,
    Words,
    layout_of,
)
from ._labels import width_of, wrapped
from ._style import INK, MUTED, drawing, plain

_MARGIN, _GAP = 24, 26
_TITLE_PT, _TITLE_PX = 13.5, 26
_LEAST_WIDTH = 460
_LONGEST_PX, _MOST_PX = 25_000, 60_000_000  # matplotlib has limits, and so has memory
_FILL, _LINE = "#e6e9f5", "#414b58"


def draw_template(template: Template, constants: Mapping[str, object] | None = None) -> Figure:
    """Draw a template as laid out in its file: locations, edges through their nails, labels in UPPAAL's colours.

    Args:
        template: a template of a document.
        constants: values by name; those that the template mentions are listed under its title.

    Raises:
        UsageError: the figure would be too large.
    """
    with drawing():
        return _draw(template, constants or {})


def _draw(template: Template, constants: Mapping[str, object]) -> Figure:
    layout, title = layout_of(template), _title(template)
    box = layout.box
    width = max(box.x1 - box.x0, _LEAST_WIDTH, width_of(title, _TITLE_PT, "bold") * PX_PER_IN)
    told = mentioned(template, constants)
    heading = wrapped(", ".join(told), FONT_PT, "normal", width / PX_PER_IN) if told else []
    above = _TITLE_PX + LINE_PX * (len(heading) + 1) + _GAP
    left, right = box.x0 - _MARGIN, box.x0 + width + _MARGIN
    top, bottom = box.y0 - above - _MARGIN, box.y1 + _MARGIN
    if (right - left) * (bottom - top) > _MOST_PX or max(right - left, bottom - top) > _LONGEST_PX:
        what = f"'{title}' is {right - left:.0f} by {bottom - top:.0f} pixels: too large to be drawn."
        where = template.place.where(0)
        raise UsageError(what, where=where, todo="Is a coordinate wrong, or a label very long?")
    figure = Figure(figsize=((right - left) / PX_PER_IN, (bottom - top) / PX_PER_IN))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    axes.set_axis_off()
    _draw_heading(axes, box.x0, top + _MARGIN, title, heading)
    for arrow, colour in layout.arrows:
        _draw_arrow(axes, arrow, _colour(colour, _LINE))
    for disc in layout.discs:
        _draw_disc(axes, disc)
    for words in layout.words:
        _draw_words(axes, words)
    return figure


def _title(template: Template) -> str:
    name = plain(template.name.content.strip(), 80)
    if template.parameters is None or not template.parameters.content.strip():
        return name
    return f"{name}({plain(' '.join(template.parameters.content.split()), 160)})"


def _draw_heading(axes: Axes, x: float, y: float, title: str, heading: list[str]) -> None:
    axes.text(x, y + 17, title, fontsize=_TITLE_PT, weight="bold", va="baseline")
    y += _TITLE_PX
    for line in heading:
        axes.text(x, y + 12, line, fontsize=FONT_PT, color=MUTED, va="baseline")
        y += LINE_PX
    for kind, word in LEGEND.items():
        axes.text(x, y + 12, word, fontsize=FONT_PT, color=COLOURS[kind], va="baseline")
        x += (width_of(word, FONT_PT) * PX_PER_IN) + 14


def _draw_arrow(axes: Axes, arrow: Arrow, colour: str) -> None:
    point, left, right = arrow.tip
    vertices, codes = [arrow.corners[0]], [Path.MOVETO]
    for begin, corner, end in arrow.rounded():
        vertices += [begin, corner, end]
        codes += [Path.LINETO, Path.CURVE3, Path.CURVE3]
    vertices.append(((left[0] + right[0]) / 2, (left[1] + right[1]) / 2))
    codes.append(Path.LINETO)
    line = Path(vertices, codes)
    axes.add_patch(PathPatch(line, fill=False, edgecolor=colour, linewidth=0.9, zorder=2))
    axes.add_patch(Polygon([point, left, right], closed=True, facecolor=colour, edgecolor="none", zorder=2))


def _draw_disc(axes: Axes, disc: Disc) -> None:
    centre, fill = (disc.x, disc.y), _colour(disc.fill, _FILL)
    axes.add_patch(Circle(centre, RADIUS, facecolor=fill, edgecolor=INK, linewidth=1.0, zorder=3))
    if disc.initial:
        axes.add_patch(Circle(centre, RADIUS - 3.2, fill=False, edgecolor=INK, linewidth=0.9, zorder=3))
    if disc.mark:
        size = FONT_PT * (0.72 if disc.initial else 0.9)
        axes.text(
            *centre, disc.mark, fontsize=size, weight="bold", ha="center", va="center_baseline", zorder=4
        )


def _draw_words(axes: Axes, words: Words) -> None:
    style = "italic" if words.kind == "comments" else "normal"
    for number, line in enumerate(words.lines):
        axes.text(
            words.x,
            words.baseline(number),
            line,
            fontsize=FONT_PT,
            color=COLOURS[words.kind],
            style=style,
            va="baseline",
            zorder=5,
        )


def _colour(given: str, otherwise: str) -> str:
    """Return a colour of the file if it is well-formed, as UPPAAL writes it, else the default."""
    known = (
        len(given) == 7 and given[0] == "#" and all(each in "0123456789abcdefABCDEF" for each in given[1:])
    )
    return given if known else otherwise


_SHORT = 4  # as many equal elements are written out


def mentioned(template: Template, constants: Mapping[str, object]) -> list[str]:
    """Return texts such as ``N = 3``, ``T_CONFIRM = {5000, 5000, 5000}``, in the order of the constants."""
    words = {word for text in _texts(template) for word in re.findall(r"\w+", text)}
    return [f"{name} = {_written(value)}" for name, value in constants.items() if name in words]


def _texts(template: Template) -> Iterator[str]:
    for text in (template.parameters, template.declarations):
        if text:
            yield text.content
    labels = [each.labels for each in template.locations] + [each.labels for each in template.edges]
    for kind, label in (item for each in labels for item in each.items()):
        if kind != "comments":
            yield label.text.content


def _written(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if not isinstance(value, Sequence):
        return str(value)
    items = [_written(item) for item in value]
    if len(items) > _SHORT and len(set(items)) == 1:
        return f"{{{items[0]}, … {len(items)} times}}"
    return "{" + ", ".join(items) + "}"
