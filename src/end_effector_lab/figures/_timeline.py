"""The default figure of a run: events, lanes and pressures on one time axis, with the verdict as its title."""

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

from ._events import FOOT_IN, ROW_IN, Event, draw_events, line_of, lined, place_events
from ._lanes import GAP_IN, Lane, all_lanes_of, draw_lane, write_lane
from ._page import EDGE_IN, WIDTH_IN, Page, draw_heading, heading_of, need_rows, page_of
from ._panels import draw_panel, labels_width, panels_of
from ._style import DPI, RULE, WRONG, drawing
from ._watched import (
    CLOCK_IN,
    clock_labels_width,
    draw_clock,
    draw_steps,
    last_switched_s,
    switch_lanes,
    watched_clocks,
    watched_lanes,
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
    """A figure of a fixed height; positions are in inches from its upper edge."""

    figure: Figure
    page: Page
    height: float

    def axes(self, y0: float, y1: float) -> Axes:
        """Return new axes over the time of the recording."""
        page, height, width = self.page, self.height, self.figure.get_figwidth()
        place = (page.left / width, 1 - y1 / height, page.width / width, (y1 - y0) / height)
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


def timeline(
    log: StatesLog,
    pressures: PressuresLog | None = None,
    info: RunInfo | None = None,
    alarms: Sequence[AlarmRow] = (),
    moments: Sequence[Moment] = (),
    changer: Sequence[ChangerRow] = (),
    switches: SwitchesLog | None = None,
    width_in: float = WIDTH_IN,
) -> Figure:
    """Draw states as lanes with their names inside, events above, and switches and pressures with thresholds below.

    ``moments``: marked in addition to those of the story; ``changer``: the lane of the tool changer; ``switches``: a
    lane for each switch whose meaning the run gives, and one for the e-stop.

    Raises UsageError for a recording without a row.
    """
    need_rows(log)
    info = (info or RunInfo()).gripping(log.parts)
    with drawing():
        story = read_story(log, info, alarms)
        panels = panels_of(pressures, info, log.actuators)
        clocks = watched_clocks(info)
        words_in = max(labels_width(panels), clock_labels_width(clocks))
        page = page_of(
            log,
            pressures if panels else None,
            words_in,
            [*info.switches, *(each.name for each in info.watched)],
            last_switched_s(switches, info),
            width_in,
        )
        shown = [moment for moment in moments if page.start_s <= moment.time_s <= page.end_s]
        told = sorted((*story.moments, *shown), key=lambda moment: moment.time_s)
        events = place_events(told, page.x, page.width + EDGE_IN)
        crossed = [page.x(event.moment.time_s) for event in events]
        lanes = all_lanes_of(log, info, page.end_s, pressures, changer)
        lanes += switch_lanes(switches, info, page.end_s)
        lanes += watched_lanes(info, page.end_s)
        lanes[1].ruled = len(lanes) > 2
        for lane in lanes:
            write_lane(lane, page.x, page.width, crossed)
        heading = heading_of(story, info, width_in - page.left - EDGE_IN)
        lanes_at = heading.height_in + (1 + max((event.row for event in events), default=0)) * ROW_IN
        lanes_end = lanes_at + FOOT_IN + sum(lane.height_in for lane in lanes)
        heights = [*(panel.height_in for panel in panels), *(CLOCK_IN for _ in clocks)]
        panels_end = lanes_end + sum(height + PANEL_GAP_IN for height in heights)
        height = panels_end + AXIS_IN
        sheet = FigureSheet(Figure(figsize=(width_in, height), facecolor="white", dpi=DPI), page, height)
        draw_heading(sheet.figure, heading, page.left)
        deadlines = [each.deadline_s for each in clocks if each.deadline_s is not None]
        draw_lanes(sheet, lanes, events, (heading.height_in, lanes_at, lanes_end), deadlines)
        plots = [
            *(partial(draw_panel, panel=each) for each in panels),
            *(partial(draw_clock, clock=each) for each in clocks),
        ]
        draw_plots(sheet, list(zip(heights, plots, strict=True)), events, lanes_end, deadlines)
        return sheet.figure
