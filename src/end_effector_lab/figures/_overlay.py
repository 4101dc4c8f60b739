"""Two runs over each other: the lanes of both, their pressures in one plot, and where they differ."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from end_effector_hal.recording import Moment, RunDifference, RunTables, count_differences
from end_effector_hal.vocabulary import display_name

from ._labels import packed, wrapped
from ._save import DPI
from ._style import drawing, plain
from .parts import (
    AXIS_IN,
    EDGE_IN,
    FOOT_IN,
    GAP_IN,
    PANEL_GAP_IN,
    ROW_IN,
    WIDTH_IN,
    FigureSheet,
    Heading,
    Lane,
    Page,
    Panel,
    all_lanes_of,
    draw_heading,
    draw_lanes,
    draw_panel,
    draw_plots,
    labels_width,
    last_switched_s,
    need_rows,
    page_of,
    panels_of,
    place_events,
    sources,
    switch_lanes,
    write_lane,
)

_PAIR_GAP_IN = 0.12
_SECOND = (0, (4, 1.6))
_MOST_MARKED = 24
"""Further differences are in the list only."""


def overlay(
    first: RunTables, second: RunTables, differences: Sequence[RunDifference], names: tuple[str, str]
) -> Figure:
    """Two runs over each other, on the clock of the first one: each line twice, each pressure solid and dashed.

    ``differences``: are marked; ``names``: of both. Raises UsageError for a recording without a row.
    """
    need_rows(first.log)
    need_rows(second.log)
    with drawing():
        shift_s = first.first_command_s - second.first_command_s
        second = second.later(shift_s)
        panels, others = _panels(first), _panels(second)
        page = _page(first, second, labels_width(panels))
        lanes = _pairs(_lanes(first, page), _lanes(second, page))
        moments = [_moment(each, shift_s) for each in differences if _is_marked(each, lanes)][:_MOST_MARKED]
        events = place_events(sorted(moments, key=lambda each: each.time_s), page.x, page.width + EDGE_IN)
        crossed = [page.x(event.moment.time_s) for event in events]
        for lane in lanes:
            write_lane(lane, page.x, page.width, crossed)
        heading = _heading(first, second, differences, names, WIDTH_IN - page.left - EDGE_IN)
        lanes_at = heading.height_in + (1 + max((event.row for event in events), default=0)) * ROW_IN
        lanes_end = lanes_at + FOOT_IN + sum(lane.height_in for lane in lanes)
        heights = [panel.height_in for panel in panels]
        height = lanes_end + sum(each + PANEL_GAP_IN for each in heights) + AXIS_IN
        sheet = FigureSheet(Figure(figsize=(WIDTH_IN, height), facecolor="white", dpi=DPI), page, height)
        draw_heading(sheet.figure, heading, page.left)
        draw_lanes(sheet, lanes, events, (heading.height_in, lanes_at, lanes_end))
        plots = [partial(_draw_both, panel=each, others=others) for each in panels]
        since = f"start of {plain(names[0])}"
        draw_plots(sheet, list(zip(heights, plots, strict=True)), events, lanes_end, since=since)
        return sheet.figure


def _is_marked(difference: RunDifference, lanes: Sequence[Lane]) -> bool:
    """Those of states: the curves show the others, and alarms are long."""
    timed = difference.first_s is not None or difference.second_s is not None
    return timed and any(lane.name == difference.line for lane in lanes)


def _moment(difference: RunDifference, shift_s: float) -> Moment:
    """On the clock of the first recording."""
    at = difference.first_s if difference.first_s is not None else (difference.second_s or 0.0) + shift_s
    return Moment(at, "missed", f"{display_name(difference.line)}: {plain(difference.text, 48)}")


def _heading(
    first: RunTables,
    second: RunTables,
    differences: Sequence[RunDifference],
    names: tuple[str, str],
    width: float,
) -> Heading:
    one, other = (plain(name) for name in names)
    title = f"{one} and {other}: {count_differences(len(differences))}"
    said = [f"{one}, the upper lanes and solid: {', '.join(sources(first.info)[:3])}"]
    said += [f"{other}, the lower lanes and dashed: {', '.join(sources(second.info)[:3])}"]
    return Heading(wrapped(title, 13.5, "bold", width), [], packed(said, "  ·  ", 9.5, "normal", width))


def _page(first: RunTables, second: RunTables, words_in: float) -> Page:
    """The whole time of both."""
    pages = [
        page_of(
            each.log,
            each.pressures,
            words_in,
            list(each.info.switches),
            last_switched_s(each.switches, each.info),
        )
        for each in (first, second)
    ]
    start = min(each.log.rows[0].time_s for each in (first, second))
    return Page(
        min(start, *(each.start_s for each in pages)),
        max(each.end_s for each in pages),
        max(each.left for each in pages),
        min(each.width for each in pages),
    )


def _lanes(run: RunTables, page: Page) -> list[Lane]:
    measured_s = run.pressures.times_s[-1] if run.pressures and run.pressures.samples else 0.0
    last_s = max(run.log.rows[-1].time_s, measured_s, last_switched_s(run.switches, run.info))
    end_s = min(last_s, page.end_s)
    lanes = all_lanes_of(run.log, run.info, end_s, run.pressures, run.changer)
    return [*lanes, *(replace(each, caption="") for each in switch_lanes(run.switches, run.info, end_s))]


def _pairs(lanes: list[Lane], others: list[Lane]) -> list[Lane]:
    """Those of the first above those of the second; a lane of one only stands above or below an empty one."""
    by_name, second = {lane.name: lane for lane in lanes}, {lane.name: lane for lane in others}
    found = []
    for name in dict.fromkeys([*by_name, *second]):
        known = by_name.get(name) or second[name]
        title, empty = known.title, Lane(name, known.title, [], bar_in=known.bar_in)
        found += [
            replace(by_name.get(name) or empty, title=title),
            replace(second.get(name) or empty, title="the second", gap_in=GAP_IN + _PAIR_GAP_IN, ruled=True),
        ]
    return found


def _panels(run: RunTables) -> list[Panel]:
    return panels_of(run.pressures, run.info, run.log.actuators)


def _draw_both(axes: Axes, panel: Panel, others: Sequence[Panel]) -> None:
    """The panel of the first run, and the curves of the second dashed over it."""
    draw_panel(axes, panel)
    for other in others:
        for curve in other.curves if other.below == panel.below else ():
            axes.plot(
                curve.times_s, curve.kpa, color=curve.colour, linestyle=_SECOND, linewidth=1.3,
                label=f"{curve.title} of the second",
            )  # fmt: skip
