"""A lane as it is drawn."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from end_effector_lab.figures._lanes import BAR_IN, TEXT, Beside, Inside, Lane, Segment, least_width
from end_effector_lab.figures._page import Page, write_name
from end_effector_lab.figures._save import DPI
from end_effector_lab.figures._style import INK, fill_of, ink_of, kind_of

_BORDER_IN = 0.06
"""Segments wider than this are parted by a white line; it would hide narrower ones."""


def draw_lane(axes: Axes, page: Page, lane: Lane, top: float) -> None:
    """Bars and words of a lane whose upper edge is at ``top``, inches downwards."""
    write_name(axes, page, lane.title, top + BAR_IN / 2)
    before = 0.0
    seen: set[tuple[int, int]] = set()
    for segment in lane.segments:
        width = page.x(segment.end_s) - page.x(segment.start_s)
        least = least_width(lane, segment, page.width)
        spot = (int(segment.state), round(page.x(segment.start_s) * DPI))
        # in a long recording thousands of short states fall on one column of pixels
        if width >= least or spot not in seen:
            _draw_bar(axes, page, lane, segment, top, least)
        seen.add(spot)
        if min(width, before) > _BORDER_IN:
            axes.plot([segment.start_s] * 2, [top, top + BAR_IN], color="white", linewidth=1.6, zorder=2.1)
        before = width
    for inside in lane.inside:
        _write_inside(axes, page, inside, top + BAR_IN / 2)
    for beside in lane.beside:
        _write_beside(axes, page, beside, top + BAR_IN)


def _draw_bar(axes: Axes, page: Page, lane: Lane, segment: Segment, top: float, least: float) -> None:
    left, right = page.x(segment.start_s), page.x(segment.end_s)
    error = kind_of(segment.state) == "error"
    zorder = 2.0
    if right - left < least:
        middle, half = (left + right) / 2, least / 2
        left, right = middle - half, middle + half
        zorder = 2.3 if error else 2.2
    bar = Rectangle((page.seconds(left), top), page.seconds(right) - page.seconds(left), BAR_IN)
    bar.set(facecolor=fill_of(segment.state), linewidth=0, clip_on=False, zorder=zorder)
    bar.set_label(f"{lane.name}: {segment.state.label}")
    axes.add_patch(bar)


def _write_inside(axes: Axes, page: Page, inside: Inside, y: float) -> None:
    axes.text(
        page.seconds(inside.x),
        y,
        inside.text,
        ha="center",
        va="center_baseline",
        color=ink_of(inside.segment.state),
        fontsize=inside.size,
        zorder=4,
        label="inside",
        # a line of an event passes behind the words
        bbox={"facecolor": fill_of(inside.segment.state), "edgecolor": "none", "pad": 1.0},
    )


def _write_beside(axes: Axes, page: Page, beside: Beside, foot: float) -> None:
    state, box = beside.segment.state, beside.box
    colour = fill_of(state) if kind_of(state) == "error" else INK
    xs = [page.seconds(beside.start[0]), page.seconds(beside.end[0])]
    ys = [foot + beside.start[1], foot + beside.end[1]]
    axes.plot(xs, ys, color=colour, linewidth=0.9, zorder=4, clip_on=False)
    axes.text(
        page.seconds((box.x0 + box.x1) / 2),
        foot + (box.y0 + box.y1) / 2,
        beside.text,
        ha="center",
        va="center_baseline",
        color=colour,
        fontsize=TEXT,
        zorder=5,
        label="beside",
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6},
    )
