"""The paper's figure: step curves with offsets, state names at transitions (Figs. 7 to 9); in inches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from math import ceil

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from end_effector_hal.recording import RunInfo, StatesLog

from ._labels import Box, Point, Sheet, height_of, width_of
from ._lanes import Lane, Segment, lanes_of
from ._page import WIDTH_IN, need_rows, span_of
from ._style import DPI, INK, drawing

UNIT_IN = 0.2
TEXT = 8.5
COLOURS = ("#0072b2", "#1d2733", "#d55e00", "#009e73", "#aa4499", "#b08800", "#4f9fd4")
_FOOT, _BETWEEN = 1.2, 2.0
"""Room for the names, in units: below the lowest curve, and between two curves."""

_AGAIN_IN = 0.15
"""Width in inches within which the name of a repeated state is not tried again."""

_NEAR = [(dx, dy) for dx in (0.04, -0.04) for dy in (0.1, -0.1)]
_FAR = [
    (sign * dx, turn * dy)
    for dy in (0.16, 0.26, 0.36, 0.46, 0.56, 0.7)
    for dx in (0.12, 0.3, 0.5)
    for turn in (1, -1)
    for sign in (1, -1)
]
_TRIALS = [
    *product((False,), (*_NEAR, *_FAR)),
    *product((True,), ((dx, dy) for dx, dy in _FAR if max(abs(dx), abs(dy)) < 0.4)),
]
"""Pairs of (whether the leader may cross a curve, offset), the best first."""


@dataclass(frozen=True)
class Curve:
    """The curve of one element: its value plus ``offset`` is drawn."""

    lane: Lane
    title: str
    colour: str
    offset: float

    def level(self, segment: Segment) -> float:
        """Return the height of a segment, in units from the foot of the figure."""
        return self.offset + segment.level


@dataclass(frozen=True)
class Name:
    """The name of a state: the middle of its text, and a leader if the text is further away."""

    curve: Curve
    segment: Segment
    middle: Point
    leader: tuple[Point, Point] | None


def curves_of(lanes: list[Lane]) -> tuple[list[Curve], float]:
    """Return the curves (command, end-effector, actuators in sequence) and their total height in units."""
    end_effector, command, *actuators = lanes
    titles = ["HAL command", "End-effector", *(lane.title for lane in actuators)]
    curves: list[Curve] = []
    foot = _FOOT
    for index, lane in reversed(list(enumerate([command, end_effector, *actuators]))):
        values = [segment.level for segment in lane.segments]
        curves.append(Curve(lane, titles[index], COLOURS[index % len(COLOURS)], foot - min(values)))
        foot += max(max(values) - min(values), 1) + _BETWEEN
    return curves[::-1], foot


def place_names(curves: list[Curve], start_s: float, per_second: float, frame: Box) -> list[Name]:
    """Find a place for the name at each transition that overlaps no other name and no curve.

    The first choice is just after the transition and above the new level; then further away with a leader; a name
    without room is omitted.

    Args:
        curves: all curves.
        start_s: the time at the left edge.
        per_second: inches per second.
        frame: names stay inside of it.
    """
    sheet = Sheet()
    for curve in curves:
        runs = [
            ((s.start_s - start_s) * per_second, (s.end_s - start_s) * per_second, curve.level(s) * UNIT_IN)
            for s in curve.lane.segments
        ]
        for left, right, y in runs:
            sheet.take_line((left, y), (right, y))
        for (_, right, y0), (_, _, y1) in pairwise(runs):
            sheet.take_line((right, y0), (right, y1))
    names = []
    for curve in curves:
        tried: set[tuple[int, int]] = set()
        # an error first: where there is no room for all names, its name stays
        for segment in sorted(curve.lane.segments, key=lambda s: (s.kind != "error", s.start_s)):
            x = (segment.start_s - start_s) * per_second
            spot = (segment.level, int(x / _AGAIN_IN))
            name = None if spot in tried else _place(curve, segment, x, sheet, frame)
            tried.add(spot)
            if name is not None:
                names.append(name)
    return names


def _place(curve: Curve, segment: Segment, x: float, sheet: Sheet, frame: Box) -> Name | None:
    width, height = width_of(segment.state.label, TEXT) + 0.04, height_of(TEXT)
    y = curve.level(segment) * UNIT_IN
    for crossing, (dx, dy) in _TRIALS:
        left = x + dx if dx >= 0 else x + dx - width
        box = Box(left, y + dy - height / 2, left + width, y + dy + height / 2)
        near = (left if dx >= 0 else left + width, y + dy)
        if not box.within(frame) or not sheet.free(box):
            continue
        leader = None if (dx, dy) in _NEAR else ((x, y), near)
        if leader is not None:
            # a leader passes no words, and other curves only where nothing else is left
            if not sheet.free_line(*leader) or (not crossing and sheet.crosses(*leader)):
                continue
            sheet.take_line(*leader)
        sheet.take(box)
        return Name(curve, segment, (left + width / 2, y + dy), leader)
    return None


_LEFT, _RIGHT, _TOP, _BOTTOM = 0.75, 0.35, 0.2, 0.62
_LEGEND, _LEGEND_IN = 9.5, 0.26
_DOT_IN = 0.03


def paper(log: StatesLog, info: RunInfo | None = None) -> Figure:
    """Draw offset step curves with the state names at the transitions, as in Figs. 7 to 9 of the paper.

    Raises UsageError for a recording without a row.
    """
    need_rows(log)
    with drawing():
        start, last = span_of(log)
        end = last + max(0.06 * (last - start), 0.1)
        curves, units = curves_of(lanes_of(log, info or RunInfo(), end))
        width, depth = WIDTH_IN - _LEFT - _RIGHT, units * UNIT_IN
        columns = _columns(curves, width)
        height = _TOP + ceil(len(curves) / columns) * _LEGEND_IN + depth + _BOTTOM
        figure = Figure(figsize=(WIDTH_IN, height), facecolor="white", dpi=DPI)
        axes = figure.add_axes((_LEFT / WIDTH_IN, _BOTTOM / height, width / WIDTH_IN, depth / height))
        axes.set(xlim=(start, end), ylim=(0, units))
        per_second = width / (end - start)
        handles = [_draw_curve(axes, curve, end, per_second) for curve in curves]
        frame = Box(0.03, 0.03, width - 0.03, depth - 0.03)
        for name in place_names(curves, start, per_second, frame):
            _write_name(axes, name, start, per_second)
        _label_axes(axes, curves)
        axes.legend(
            handles=handles,
            loc="lower left",
            bbox_to_anchor=(0, 1.0),
            ncols=columns,
            frameon=False,
            fontsize=_LEGEND,
            borderaxespad=0.2,
        )
        return figure


def _columns(curves: Sequence[Curve], width: float) -> int:
    """Return the number of legend columns; each has room for the longest name and its line."""
    return max(1, int(width / (max(width_of(curve.title, _LEGEND) for curve in curves) + 0.62)))


def _draw_curve(axes: Axes, curve: Curve, end_s: float, per_second: float) -> Line2D:
    segments = curve.lane.segments
    times, levels = [s.start_s for s in segments], [curve.level(s) for s in segments]
    (line,) = axes.step(
        [*times, end_s],
        [*levels, levels[-1]],
        where="post",
        color=curve.colour,
        linewidth=1.6,
        label=curve.title,
    )
    # a state of no length lies within a jump: a dot shows where
    short = [s for s in segments if (s.end_s - s.start_s) * per_second < _DOT_IN]
    axes.plot(
        [s.start_s for s in short], [curve.level(s) for s in short], "o", color=curve.colour, markersize=4
    )
    return line


def _write_name(axes: Axes, name: Name, start_s: float, per_second: float) -> None:
    x, y = name.middle
    axes.text(
        start_s + x / per_second,
        y / UNIT_IN,
        name.segment.state.label,
        color=name.curve.colour,
        fontsize=TEXT,
        ha="center",
        va="center_baseline",
        label="name",
        # a line of the grid ends at the words; curves stand above
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.4},
        zorder=1.5,
    )
    if name.leader is not None:
        xs, ys = zip(*name.leader, strict=True)
        times = [start_s + x / per_second for x in xs]
        axes.plot(times, [y / UNIT_IN for y in ys], color=name.curve.colour, linewidth=0.6)


def _label_axes(axes: Axes, curves: Sequence[Curve]) -> None:
    """Label the axes; the integers of Table II are left of each curve, in its colour."""
    ticks = sorted(
        {(curve.level(s), str(s.level), curve.colour) for curve in curves for s in curve.lane.segments}
    )
    texts = [text.replace("-", "−") for _, text, _ in ticks]
    axes.set_yticks([level for level, _, _ in ticks], texts, fontsize=7.5)
    for tick, (_, _, colour) in zip(axes.get_yticklabels(), ticks, strict=True):
        tick.set_color(colour)
    axes.tick_params(axis="y", length=2)
    axes.tick_params(axis="x", labelsize=9.5)
    axes.grid(axis="x", color="#e3e6eb", linewidth=0.8)
    axes.set_axisbelow(True)
    axes.xaxis.set_major_locator(MaxNLocator(nbins=13, steps=[1, 2, 5, 10]))
    axes.set_xlabel("Time since start [s]", fontsize=10, color=INK)
    axes.set_ylabel("State (Table II, with an offset per curve)", fontsize=10)
