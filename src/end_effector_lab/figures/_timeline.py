"""The default figure of a run: events, lanes, pressures, and the verdict as its title."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from end_effector_hal.recording import AlarmRow, Moment, PressuresLog, RunInfo, StatesLog, read_story

from ._events import FOOT_IN, ROW_IN, Event, draw_events, line_of, lined, place_events
from ._heading import draw_heading, heading_of
from ._lanes import GAP_IN, Lane, draw_lane, lanes_of, write_lane
from ._page import EDGE_IN, WIDTH_IN, Page, page_of
from ._panels import HEIGHT_IN, Panel, draw_panel, labels_width, panels_of
from ._save import DPI
from ._style import RULE, drawing

_PANEL_GAP_IN, _AXIS_IN = 0.16, 0.62


@dataclass(frozen=True)
class _Sheet:
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
) -> Figure:
    """Measure everything, then draw it; see `end_effector_lab.figures.timeline`."""
    with drawing():
        story = read_story(log, info, alarms)
        panels = panels_of(pressures, info, log.actuators)
        page = page_of(log, pressures if panels else None, labels_width(panels))
        shown = [moment for moment in moments if page.start_s <= moment.time_s <= page.end_s]
        told = sorted((*story.moments, *shown), key=lambda moment: moment.time_s)
        events = place_events(told, page.x, page.width + EDGE_IN)
        crossed = [page.x(event.moment.time_s) for event in events]
        lanes = lanes_of(log, info, page.end_s)
        for lane in lanes:
            write_lane(lane, page.x, page.width, crossed)
        heading = heading_of(story, info, WIDTH_IN - page.left - EDGE_IN)
        lanes_at = heading.height_in + (1 + max((event.row for event in events), default=0)) * ROW_IN
        lanes_end = lanes_at + FOOT_IN + sum(lane.height_in for lane in lanes)
        panels_end = lanes_end + len(panels) * (HEIGHT_IN + _PANEL_GAP_IN)
        height = panels_end + _AXIS_IN
        sheet = _Sheet(Figure(figsize=(WIDTH_IN, height), facecolor="white", dpi=DPI), page, height)
        draw_heading(sheet.figure, heading, page.left)
        _draw_lanes(sheet, lanes, events, (heading.height_in, lanes_at, lanes_end))
        _draw_panels(sheet, panels, events, lanes_end)
        return sheet.figure


def _draw_lanes(
    sheet: _Sheet, lanes: Sequence[Lane], events: Sequence[Event], places: tuple[float, float, float]
) -> None:
    """Events and lanes share one axes: inches downwards, zero at the foot of the lowest row of events."""
    top, foot, end = places
    axes = sheet.axes(top, end)
    axes.set_ylim(end - foot, top - foot)
    axes.axis("off")
    draw_events(axes, sheet.page, events)
    below = FOOT_IN
    for lane in lanes:
        draw_lane(axes, sheet.page, lane, below)
        below += lane.height_in
        if lane.name == "command" and len(lanes) > 2:
            axes.axhline(below - GAP_IN / 2, color=RULE, linewidth=0.8, zorder=1)
    for event in lined(events):
        start = -(event.row + 0.1) * ROW_IN if event.row else FOOT_IN * 0.4
        axes.plot([event.moment.time_s] * 2, [start, below], zorder=3, **line_of(event))


def _draw_panels(sheet: _Sheet, panels: Sequence[Panel], events: Sequence[Event], top: float) -> None:
    """Pressures, and the axis of time below the last of them, or below the lanes where there are none."""
    if not panels:
        axes = sheet.axes(top, top + 0.02)
        axes.set_yticks([])
        axes.spines[["left", "top", "right"]].set_visible(False)
        axes.tick_params(labelsize=9.5)
        _label_time(axes)
    for panel in panels:
        top += _PANEL_GAP_IN
        axes = sheet.axes(top, top + HEIGHT_IN)
        top += HEIGHT_IN
        draw_panel(axes, panel)
        for event in lined(events):
            axes.axvline(event.moment.time_s, zorder=1, **line_of(event))
        last = panel is panels[-1]
        axes.tick_params(labelsize=9.5, labelbottom=last, bottom=last)
        axes.spines["bottom"].set_visible(last)
        axes.yaxis.set_label_coords(-0.62 / sheet.page.width, 0.5)
        if last:
            _label_time(axes)


def _label_time(axes: Axes) -> None:
    axes.xaxis.set_major_locator(MaxNLocator(nbins=13, steps=[1, 2, 5, 10]))
    axes.set_xlabel("time since start [s]", fontsize=10)
