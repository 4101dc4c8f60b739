"""The paper's own figure: step curves with offsets, state names at the transitions (Figs. 7 to 9)."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from end_effector_hal.recording import RunInfo, StatesLog
from end_effector_lab.figures._curves import TEXT, UNIT_IN, Curve, Name, curves_of, place_names
from end_effector_lab.figures._labels import Box, width_of
from end_effector_lab.figures._lanes import lanes_of
from end_effector_lab.figures._page import WIDTH_IN
from end_effector_lab.figures._save import DPI
from end_effector_lab.figures._style import INK, drawing

_LEFT, _RIGHT, _TOP, _BOTTOM = 0.75, 0.35, 0.2, 0.62
_LEGEND, _LEGEND_IN = 9.5, 0.26
_DOT_IN = 0.03


def draw(log: StatesLog, info: RunInfo) -> Figure:
    """See `end_effector_lab.figures.paper`."""
    with drawing():
        first, last = log.rows[0].time_s, log.rows[-1].time_s
        start = 0.0 if first <= 0.25 * last else first
        end = last + max(0.06 * (last - start), 0.1)
        curves, units = curves_of(lanes_of(log, info, end))
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
    """Of the legend; every column has room for the longest name and its line."""
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
    )
    if name.leader is not None:
        xs, ys = zip(*name.leader, strict=True)
        times = [start_s + x / per_second for x in xs]
        axes.plot(times, [y / UNIT_IN for y in ys], color=name.curve.colour, linewidth=0.6)


def _label_axes(axes: Axes, curves: Sequence[Curve]) -> None:
    """The integers of Table II stand at the left of each curve, in its colour."""
    ticks = sorted(
        {(curve.level(s), str(int(s.state)), curve.colour) for curve in curves for s in curve.lane.segments}
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
