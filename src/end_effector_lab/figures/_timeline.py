"""The default figure of a run: events, lanes, pressures, and the verdict as its title."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from end_effector_hal.recording import (
    AlarmRow,
    ChangerRow,
    Moment,
    PressuresLog,
    RunInfo,
    StatesLog,
    SwitchesLog,
    read_story,
)

from ._save import DPI
from ._style import RULE, WRONG, drawing
from .parts import (
    CLOCK_IN,
    EDGE_IN,
    FOOT_IN,
    GAP_IN,
    ROW_IN,
    WIDTH_IN,
    Event,
    Lane,
    Page,
    all_lanes_of,
    clock_labels_width,
    draw_clock,
    draw_events,
    draw_heading,
    draw_lane,
    draw_panel,
    draw_steps,
    heading_of,
    labels_width,
    line_of,
    lined,
    page_of,
    panels_of,
    place_events,
    switch_lanes,
    watched_clocks,
    watched_lanes,
    write_lane,
)

PANEL_GAP_IN, AXIS_IN = 0.16, 0.62
_DEADLINE: dict[str, Any] = {
    "color": WRONG,
    "linewidth": 1.4,
    "linestyle": (0, (1, 1.2)),
    "label": "deadline",
}


@dataclass(frozen=True)
class FigureSheet:
    """A figure of a known height; places are given in inches from its upper edge."""

    figure: Figure
    page: Page
    height: float

    def axes(self, y0: float, y1: float) -> Axes:
        """Axes over the time of the recording."""
        page, height = self.page, self.height
        place = (page.left / WIDTH_IN, 1 - y1 / height, page.width / WIDTH_IN, (y1 - y0) / height)
        axes = self.figure.add_axes(place)
        axes.set_xlim(page.start_s, page.end_s)
        axes.patch.set_visible(False)
        return axes


def draw(
    log: StatesLog,
    pressures: PressuresLog | None,
    info: RunInfo,
    alarms: Sequence[AlarmRow] = (),
    moments: Sequence[Moment] = (),
    changer: Sequence[ChangerRow] = (),
    switches: SwitchesLog | None = None,
) -> Figure:
    """Measure everything, then draw it; see `end_effector_lab.figures.timeline`."""
    with drawing():
        story = read_story(log, info, alarms)
        panels = panels_of(pressures, info, log.actuators, alarms)
        clocks = watched_clocks(info)
        words_in = max(labels_width(panels), clock_labels_width(clocks))
        page = page_of(
            log,
            pressures if panels else None,
            words_in,
            [*info.switches, *(each.name for each in info.watched)],
        )
        shown = [moment for moment in moments if page.start_s <= moment.time_s <= page.end_s]
        told = sorted((*story.moments, *shown), key=lambda moment: moment.time_s)
        events = place_events(told, page.x, page.width + EDGE_IN)
        crossed = [page.x(event.moment.time_s) for event in events]
        lanes = all_lanes_of(log, info, page.end_s, pressures, changer)
        lanes += switch_lanes(switches, info, page.end_s)
        lanes += watched_lanes(info, page.end_s)
        for lane in lanes:
            write_lane(lane, page.x, page.width, crossed)
        heading = heading_of(story, info, WIDTH_IN - page.left - EDGE_IN)
        lanes_at = heading.height_in + (1 + max((event.row for event in events), default=0)) * ROW_IN
        lanes_end = lanes_at + FOOT_IN + sum(lane.height_in for lane in lanes)
        heights = [*(panel.height_in for panel in panels), *(CLOCK_IN for _ in clocks)]
        panels_end = lanes_end + sum(height + PANEL_GAP_IN for height in heights)
        height = panels_end + AXIS_IN
        sheet = FigureSheet(Figure(figsize=(WIDTH_IN, height), facecolor="white", dpi=DPI), page, height)
        draw_heading(sheet.figure, heading, page.left)
        deadlines = [each.deadline_s for each in clocks if each.deadline_s is not None]
        draw_lanes(sheet, lanes, events, (heading.height_in, lanes_at, lanes_end), deadlines)
        plots = [
            *(partial(draw_panel, panel=each) for each in panels),
            *(partial(draw_clock, clock=each) for each in clocks),
        ]
        draw_plots(sheet, list(zip(heights, plots, strict=True)), events, lanes_end, deadlines)
        return sheet.figure


def draw_lanes(
    sheet: FigureSheet,
    lanes: Sequence[Lane],
    events: Sequence[Event],
    places: tuple[float, float, float],
    deadlines: Sequence[float] = (),
) -> Axes:
    """Events and lanes share one axes: inches downwards, zero at the foot of the lowest row of events."""
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
        if lane.name == "command" and len(lanes) > 2:
            axes.axhline(below - GAP_IN / 2, color=RULE, linewidth=0.8, zorder=1)
    for event in lined(events):
        start = -(event.row + 0.1) * ROW_IN if event.row else FOOT_IN * 0.4
        axes.plot([event.moment.time_s] * 2, [start, below], zorder=3, **line_of(event))
    for at in deadlines:
        axes.plot([at] * 2, [FOOT_IN * 0.4, below], zorder=3, **_DEADLINE)
    return axes


def draw_plots(
    sheet: FigureSheet,
    plots: Sequence[tuple[float, Callable[[Axes], None]]],
    events: Sequence[Event],
    top: float,
    deadlines: Sequence[float] = (),
) -> None:
    """Plots of a height each, and the axis of time below the last of them, or below the lanes where there are none."""
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
