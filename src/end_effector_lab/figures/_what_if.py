"""A recorded run above, and below it what another description would have made of it, on one axis of time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import StatesLog
from end_effector_hal.verification.whatif import RunStory, WhatIf

from ._labels import width_of, wrapped
from ._save import DPI
from ._style import INK, RULE, WRONG, drawing, plain
from .parts import (
    AXIS_IN,
    EDGE_IN,
    FOOT_IN,
    PANEL_GAP_IN,
    ROW_IN,
    TITLE,
    WIDTH_IN,
    Event,
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
    page_of,
    panels_of,
    place_events,
    switch_lanes,
    write_lane,
)

DIFFERS, GUESS = "#fff0c2", "#8a93a0"
_TITLE_IN, _BLOCK_GAP_IN = 0.34, 0.16
_LONGEST = 300


@dataclass(frozen=True)
class _Block:
    """One of the two runs: its name, its events and its lanes; inches from the upper edge."""

    title: str
    events: list[Event]
    lanes: list[Lane]
    top: float

    @property
    def lanes_at(self) -> float:
        return self.top + _TITLE_IN + (1 + max((event.row for event in self.events), default=0)) * ROW_IN

    @property
    def end(self) -> float:
        return self.lanes_at + FOOT_IN + sum(lane.height_in for lane in self.lanes)


def what_if(told: WhatIf) -> Figure:
    """A recorded run and what another description would have made of it: lanes above each other, one axis of time.

    Raises UsageError where one of them holds no state.
    """
    ours, theirs = told.recorded, told.other
    if not ours.rows or not theirs.rows:
        raise UsageError("One of the two runs holds no state, so there is nothing to draw.")
    with drawing():
        panels, marks = _panels(told)
        page = _page(told, labels_width(panels))
        words = "from the red line on an output differs, and the readings answer the recorded one: a guess"
        width, name = WIDTH_IN - page.left - EDGE_IN, f"With {plain(theirs.description.source.name, 40)}"
        title = wrapped(f"Recorded: {ours.story.verdict}", TITLE, "bold", width)
        title += wrapped(f"{name}: {theirs.story.verdict}", TITLE, "bold", width)
        heading = Heading(title, [], [_source(told)])
        first = _block(ours, "Recorded", told, page, heading.height_in + 0.22)
        second = _block(theirs, name, told, page, first.end + _BLOCK_GAP_IN)
        heights = [panel.height_in for panel in panels]
        height = second.end + sum(each + PANEL_GAP_IN for each in heights) + AXIS_IN
        sheet = FigureSheet(Figure(figsize=(WIDTH_IN, height), facecolor="white", dpi=DPI), page, height)
        draw_heading(sheet.figure, heading, page.left)
        _draw_legend(sheet, heading.height_in, words)
        _draw_differences(sheet, told, first, second)
        for block in (first, second):
            _draw_block(sheet, block)
        plots = [partial(_draw_panel, panel=panel, other=marks[index]) for index, panel in enumerate(panels)]
        draw_plots(sheet, list(zip(heights, plots, strict=True)), [], second.end)
        return sheet.figure


def differing(first: StatesLog, second: StatesLog, end_s: float) -> Iterator[tuple[float, float]]:
    """From when to when any state differs, s; an actuator that only one tool has does not count."""
    shared = [name for name in first.actuators if name in second.actuators]

    def shown(log: StatesLog, index: int) -> tuple[int, ...]:
        if index < 0:
            return ()
        row = log.rows[index]
        return (row.end_effector, row.command, *(row.actuators[log.actuators.index(name)] for name in shared))

    times = sorted({*first.times_s, *second.times_s})
    since: float | None = None
    one = other = -1
    for at in times:
        while one + 1 < len(first.rows) and first.rows[one + 1].time_s <= at:
            one += 1
        while other + 1 < len(second.rows) and second.rows[other + 1].time_s <= at:
            other += 1
        if shown(first, one) != shown(second, other):
            since = at if since is None else since
        elif since is not None:
            yield since, at
            since = None
    if since is not None:
        yield since, end_s


def _page(told: WhatIf, words_in: float) -> Page:
    logs = [told.recorded.log, told.other.log]
    pressures = told.pressures if told.pressures.samples else None
    names = [*told.recorded.info.switches, *told.other.info.switches]
    switched_s = max(last_switched_s(told.switches, side.info) for side in (told.recorded, told.other))
    pages = [page_of(log, pressures, words_in, names, switched_s) for log in logs]
    narrow = max(pages, key=lambda page: page.left)
    return replace(
        narrow, start_s=min(page.start_s for page in pages), end_s=max(page.end_s for page in pages)
    )


def _block(side: RunStory, title: str, told: WhatIf, page: Page, top: float) -> _Block:
    moments = [each for each in side.story.moments if page.start_s <= each.time_s <= page.end_s]
    events = place_events(moments, page.x, page.width + EDGE_IN)
    lanes = all_lanes_of(side.log, side.info, page.end_s, told.pressures, side.changer)
    lanes += switch_lanes(told.switches, side.info, page.end_s)
    lanes[1].ruled = len(lanes) > 2
    crossed = [page.x(event.moment.time_s) for event in events]
    for lane in lanes:
        write_lane(lane, page.x, page.width, crossed)
    return _Block(title, events, lanes, top)


def _panels(told: WhatIf) -> tuple[list[Panel], list[list[tuple[float, str]]]]:
    """The pressures with the thresholds of the recorded tool, and those that the other one has elsewhere."""
    panels = panels_of(told.pressures, told.recorded.info, told.recorded.log.actuators)
    others = {
        panel.title: panel for panel in panels_of(told.pressures, told.other.info, told.other.log.actuators)
    }
    marks: list[list[tuple[float, str]]] = []
    for panel in panels:
        theirs = others.get(panel.title, panel)
        found = [(limit, "confirmed") for limit in theirs.bands if limit not in panel.bands]
        found += [(limit, word) for word, limit in theirs.lines if (word, limit) not in panel.lines]
        marks.append(found)
    return panels, marks


def _draw_panel(axes: Axes, panel: Panel, other: Sequence[tuple[float, str]]) -> None:
    draw_panel(axes, panel)
    for limit, word in other:
        axes.axhline(limit, color=INK, linestyle=(0, (6, 2)), linewidth=1.1, zorder=2, label=f"other {word}")
        axes.annotate(
            f"other: {word} {limit:g}".replace("-", "−"), (0.0, limit), xycoords=("axes fraction", "data"),
            xytext=(4, 2), textcoords="offset points", fontsize=8.5, color=INK,
        )  # fmt: skip


def _draw_block(sheet: FigureSheet, block: _Block) -> None:
    page, height = sheet.page, sheet.height
    y = 1 - (block.top + _TITLE_IN / 2) / height
    sheet.figure.text(page.left / WIDTH_IN, y, block.title, fontsize=11.5, fontweight="bold", va="center")
    draw_lanes(sheet, block.lanes, block.events, (block.top + _TITLE_IN, block.lanes_at, block.end))


def _draw_differences(sheet: FigureSheet, told: WhatIf, first: _Block, second: _Block) -> None:
    """Behind both blocks: when their states differ; behind the lower one, from when on it is a guess."""
    page = sheet.page
    axes = sheet.axes(first.top + _TITLE_IN, second.end)
    axes.set_ylim(second.end, first.top + _TITLE_IN)
    axes.axis("off")
    axes.set_zorder(-2)
    for since, until in differing(told.recorded.log, told.other.log, page.end_s):
        axes.axvspan(
            since,
            max(until, since + 0.002 * (page.end_s - page.start_s)),
            color=DIFFERS,
            linewidth=0,
            label="differs",
        )
    axes.axhline((first.end + second.top) / 2 + _BLOCK_GAP_IN / 4, color=RULE, linewidth=0.9)
    for span in told.spans:
        since = told.seconds(span.since)
        until = page.end_s if span.until is None else min(told.seconds(span.until), page.end_s)
        low, high = second.lanes_at + FOOT_IN / 2, second.end
        axes.add_patch(
            Rectangle(
                (since, low), max(until - since, 0.0), high - low,
                facecolor="none", edgecolor=GUESS, hatch="////", linewidth=0, alpha=0.35, label="guess",
            )
        )  # fmt: skip
        axes.plot([since, since], [low, high], color=WRONG, linewidth=1.6, label="apart")


def _draw_legend(sheet: FigureSheet, top: float, words: str) -> None:
    """Below the legend of the states: what the marks of this figure mean."""
    left, height = sheet.page.left, sheet.height
    y = 1 - top / height
    for fill, hatch, text in ((DIFFERS, "", "the two runs differ"), ("none", "////", words)):
        box = Rectangle(
            (left / WIDTH_IN, y - 0.06 / height), 0.22 / WIDTH_IN, 0.12 / height,
            facecolor=fill, hatch=hatch, edgecolor=GUESS if hatch else fill, linewidth=0.6 if hatch else 0,
        )  # fmt: skip
        box.set(transform=sheet.figure.transFigure, label=text)
        sheet.figure.add_artist(box)
        left += 0.3
        sheet.figure.text(left / WIDTH_IN, y, text, fontsize=9.5, va="center_baseline")
        left += width_of(text, 9.5) + 0.25


def _source(told: WhatIf) -> str:
    ours, theirs = told.recorded.info, told.other.info
    return plain(
        f"{ours.description} {ours.hash[:8]}  ·  other: {theirs.description} {theirs.hash[:8]}  ·  the same readings",
        _LONGEST,
    )
