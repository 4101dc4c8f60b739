"""The sheet of a figure over time: lanes with their events at the top, plots below, one time axis."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from end_effector_lab.figures._style import RULE, WRONG

from ._events import FOOT_IN, ROW_IN, Event, draw_events, line_of, lined
from ._lanes import GAP_IN, Lane, draw_lane
from ._page import WIDTH_IN, Page
from ._switches import draw_steps

PANEL_GAP_IN, AXIS_IN = 0.16, 0.62
_DEADLINE: dict[str, Any] = {
    "color": WRONG,
    "linewidth": 1.4,
    "linestyle": (0, (1, 1.2)),
    "label": "deadline",
}


@dataclass(frozen=True)
class FigureSheet:
    """A figure of a fixed height; positions are in inches from its upper edge."""

    figure: Figure
    page: Page
    height: float

    def axes(self, y0: float, y1: float) -> Axes:
        """Return new axes over the time of the recording."""
        page, height = self.page, self.height
        place = (page.left / WIDTH_IN, 1 - y1 / height, page.width / WIDTH_IN, (y1 - y0) / height)
        axes = self.figure.add_axes(place)
        axes.set_xlim(page.start_s, page.end_s)
        axes.patch.set_visible(False)
        return axes


def draw_lanes(
    sheet: FigureSheet,
    lanes: Sequence[Lane],
    events: Sequence[Event],
    places: tuple[float, float, float],
    deadlines: Sequence[float] = (),
) -> None:
    """Draw events and lanes in one axes: inches downwards, zero at the foot of the lowest row of events."""
    top, foot, end = places
    axes = sheet.axes(top, end)
    axes.set_ylim(end - foot, top - foot)
    axes.axis("off")
    draw_events(axes, sheet.page, events)
    below = FOOT_IN
    for lane in lanes:
        draw_lane(axes, sheet.page, lane, below)
        draw_steps(axes, lane, below + lane.bar_at)
        below += lane.height_in
        if lane.ruled:
            axes.axhline(below - GAP_IN / 2, color=RULE, linewidth=0.8, zorder=1)
    for event in lined(events):
        start = -(event.row + 0.1) * ROW_IN if event.row else FOOT_IN * 0.4
        axes.plot([event.moment.time_s] * 2, [start, below], zorder=3, **line_of(event))
    for at in deadlines:
        axes.plot([at] * 2, [FOOT_IN * 0.4, below], zorder=3, **_DEADLINE)


def draw_plots(
    sheet: FigureSheet,
    plots: Sequence[tuple[float, Callable[[Axes], None]]],
    events: Sequence[Event],
    top: float,
    deadlines: Sequence[float] = (),
) -> None:
    """Draw ``(height, plot)`` pairs, and the time axis below the last plot, or below the lanes."""
    if not plots:
        axes = sheet.axes(top, top + 0.02)
        axes.set_yticks([])
        axes.spines[["left", "top", "right"]].set_visible(False)
        axes.tick_params(labelsize=9.5)
        _label_time(axes)
    for number, (height, plot) in enumerate(plots, start=1):
        top += PANEL_GAP_IN
        axes = sheet.axes(top, top + height)
        top += height
        plot(axes)
        for event in lined(events):
            axes.axvline(event.moment.time_s, zorder=1, **line_of(event))
        for at in deadlines:
            axes.axvline(at, zorder=1, **_DEADLINE)
        last = number == len(plots)
        axes.tick_params(labelsize=9.5, labelbottom=last, bottom=last)
        axes.spines["bottom"].set_visible(last)
        axes.yaxis.set_label_coords(-0.62 / sheet.page.width, 0.5)
        if last:
            _label_time(axes)


def _label_time(axes: Axes) -> None:
    axes.xaxis.set_major_locator(MaxNLocator(nbins=13, steps=[1, 2, 5, 10]))
    axes.set_xlabel("time since start [s]", fontsize=10)
