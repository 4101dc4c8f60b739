"""The default figure of a run: events, lanes and pressures, with the verdict as its title."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from matplotlib.figure import Figure

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
from ._style import drawing
from .parts import (
    AXIS_IN,
    CLOCK_IN,
    EDGE_IN,
    FOOT_IN,
    PANEL_GAP_IN,
    ROW_IN,
    WIDTH_IN,
    FigureSheet,
    all_lanes_of,
    clock_labels_width,
    draw_clock,
    draw_heading,
    draw_lanes,
    draw_panel,
    draw_plots,
    heading_of,
    labels_width,
    last_switched_s,
    need_rows,
    page_of,
    panels_of,
    place_events,
    switch_lanes,
    watched_clocks,
    watched_lanes,
    write_lane,
)


def timeline(
    log: StatesLog,
    pressures: PressuresLog | None = None,
    info: RunInfo | None = None,
    alarms: Sequence[AlarmRow] = (),
    moments: Sequence[Moment] = (),
    changer: Sequence[ChangerRow] = (),
    switches: SwitchesLog | None = None,
) -> Figure:
    """Draw states as lanes with their names inside, events above, and switches and pressures with thresholds below.

    ``moments``: marked in addition to those of the story; ``changer``: the lane of the tool changer; ``switches``: a
    lane for each switch whose meaning the run gives, and one for the e-stop.

    Raises UsageError for a recording without a row.
    """
    need_rows(log)
    info = info or RunInfo()
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
            last_switched_s(switches, info),
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
