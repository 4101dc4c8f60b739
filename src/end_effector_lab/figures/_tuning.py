"""A small plot for each number of a description: how many recorded grips would have gone otherwise, by its value."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullLocator

from end_effector_hal.errors import UsageError
from end_effector_hal.verification.tune import Tried, Tuning

from ._labels import wrapped
from ._save import DPI
from ._style import BAND, INK, MUTED, drawing, plain
from .parts import SUBTITLE, TITLE

COLUMNS, MOST = 3, 30
WIDTH_IN, PLOT_IN, HEADING_IN, EDGE_IN = 12.27, 2.35, 1.25, 0.3
WORDS = {
    "failed": ("#b8232f", "-"),
    "late": ("#b08800", "-"),
    "lost": ("#7a2f8f", (0, (5, 2))),
    "stuck": ("#0072b2", (0, (1, 1))),
    "undecided": ("#8a93a0", (0, (3, 2))),
}
"""What may become of a grip: its colour and its dashes."""
_LOG = 8.0
"""Values of which the greatest is this many times the least are drawn in equal ratios."""


def tuning(found: Tuning) -> Figure:
    """How many recorded grips would have gone otherwise, over the value of each number that changes anything.

    Raises UsageError where none does.
    """
    changing = [each for each in found.tried if each.changes]
    if not changing:
        raise UsageError(
            "No tried value changes a result, so there is nothing to draw.",
            todo="The table says from where to where each was tried.",
        )
    with drawing():
        shown = changing[:MOST]
        rows = -(-len(shown) // COLUMNS)
        height = HEADING_IN + rows * PLOT_IN + EDGE_IN
        figure = Figure(figsize=(WIDTH_IN, height), facecolor="white", dpi=DPI)
        _heading(figure, found, len(changing))
        for number, each in enumerate(shown):
            row, column = divmod(number, COLUMNS)
            width = (WIDTH_IN - 2 * EDGE_IN) / COLUMNS
            left, top = EDGE_IN + column * width + 0.45, HEADING_IN + row * PLOT_IN + 0.35
            place = (
                left / WIDTH_IN,
                1 - (top + PLOT_IN - 0.95) / height,
                (width - 0.6) / WIDTH_IN,
                (PLOT_IN - 0.95) / height,
            )
            _plot(figure.add_axes(place), each)
        return figure


def _heading(figure: Figure, found: Tuning, changing: int) -> None:
    height = figure.get_figheight()
    grips = "1 recorded grip" if found.grips == 1 else f"{found.grips} recorded grips"
    title = f"{plain(found.description.name)}: what {grips} would have become, by the value of each number"
    lines = wrapped(title, TITLE, "bold", WIDTH_IN - 2 * EDGE_IN)
    figure.text(
        EDGE_IN / WIDTH_IN, 1 - 0.2 / height, "\n".join(lines), va="top", fontsize=TITLE, fontweight="bold"
    )
    more = f"  ·  {changing - MOST} more are in the table" if changing > MOST else ""
    text = f"dashed: today's value  ·  green: nothing changes  ·  each number alone, on attempts that were made{more}"
    figure.text(EDGE_IN / WIDTH_IN, 1 - 0.62 / height, text, va="top", fontsize=SUBTITLE, color=MUTED)
    left = EDGE_IN
    for word, (colour, _) in WORDS.items():
        figure.text(
            left / WIDTH_IN, 1 - 0.92 / height, f"— {word}", va="top", fontsize=SUBTITLE, color=colour
        )
        left += 1.15


def _plot(axes: Axes, each: Tried) -> None:
    xs = [value for value, _ in each.values]
    axes.set_title(each.parameter.key.removeprefix("actuators."), fontsize=9.5, loc="left", color=INK)
    if xs[-1] / xs[0] > _LOG and not each.parameter.whole:
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.xaxis.set_minor_locator(NullLocator())
    else:
        axes.xaxis.set_major_locator(MaxNLocator(nbins=6, integer=each.parameter.whole))
    axes.axvspan(each.same_from, each.same_to, color=BAND, linewidth=0, zorder=0, label="nothing changes")
    axes.axvline(
        each.parameter.today, color=INK, linestyle=(0, (4, 3)), linewidth=1.0, zorder=1, label="today"
    )
    for word, (colour, dashes) in WORDS.items():
        ys = [getattr(counts, word) for _, counts in each.values]
        if any(ys):
            axes.plot(
                xs, ys, color=colour, linestyle=dashes, linewidth=1.6, marker=".", markersize=3.5, label=word
            )
    axes.set_ylim(-0.04 * each.grips, 1.06 * each.grips)
    axes.yaxis.set_major_locator(MaxNLocator(nbins=4, integer=True))
    axes.set_ylabel(f"of {each.grips} grips", fontsize=8.5)
    axes.set_xlabel(each.parameter.unit, fontsize=8.5, labelpad=1)
    axes.tick_params(labelsize=8.5)
    axes.spines[["top", "right"]].set_visible(False)
