"""The parts of a violated requirement: lanes for states, a plot with its deadline for each clock."""

from __future__ import annotations

import re
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from end_effector_hal.recording import RunInfo, Watched
from end_effector_lab.figures._labels import width_of
from end_effector_lab.figures._style import INK, MUTED, WRONG, ShownValue, plain

from ._beside import BESIDE_SIZE, write_beside
from ._lanes import Lane, segments_of

CLOCK_IN = 0.95
_MOST_LANES, _MOST_CLOCKS = 10, 3


def watched_lanes(info: RunInfo, end_s: float) -> list[Lane]:
    """Return lanes of variables and locations; of too many, wrong ones first, then those that change."""
    states = [each for each in info.watched if each.values]
    first = sorted(states, key=lambda each: (not each.wrong, len(each.values) == 1))[:_MOST_LANES]
    lanes = [_lane(each, info.violated_s, end_s) for each in states if each in first]
    if lanes:
        more = f" ({len(lanes)} of {len(states)})" if len(states) > len(lanes) else ""
        lanes[0].caption = f"what the requirement speaks of{more}; red: the part that does not hold"
    return lanes


def _lane(watched: Watched, violated_s: float, end_s: float) -> Lane:
    times = [at for at, _ in watched.values]
    words = [ShownValue(plain(text)) for _, text in watched.values]
    if watched.wrong:  # only what it is then is wrong
        if times[-1] < violated_s:
            times.append(violated_s)
            words.append(words[-1])
        words[-1] = ShownValue(words[-1].label, wrong=True)
    return Lane(f"watched {watched.name}", plain(watched.name), segments_of(times, words, end_s))


def watched_clocks(info: RunInfo) -> list[Watched]:
    """Return the clocks that are drawn."""
    clocks = [each for each in info.watched if each.points]
    return sorted(clocks, key=lambda each: not each.wrong)[:_MOST_CLOCKS]


def clock_labels(clock: Watched) -> list[tuple[float, str, str]]:
    """Return (s, text, colour) at the right end."""
    colour = WRONG if clock.wrong else MUTED
    return [(value, _RELATION.sub(_sign, plain(text)), colour) for text, value in clock.limits]


_RELATION = re.compile("^[<>]=")


def _sign(found: re.Match[str]) -> str:
    return "≤" if found[0] == "<=" else "≥"


def clock_labels_width(clocks: Sequence[Watched]) -> float:
    """Return the width of the text at the right, inches."""
    return max(
        (width_of(text, BESIDE_SIZE) for each in clocks for _, text, _ in clock_labels(each)), default=0.0
    )


def draw_clock(axes: Axes, clock: Watched) -> None:
    """Draw the clock over time, and its limits."""
    highest = max([value for _, value in clock.points] + [value for _, value in clock.limits] + [0.001])
    low, high = -0.05 * highest, 1.15 * highest
    axes.set_ylim(low, high)
    axes.set_ylabel(f"{plain(clock.name, 24)}\n[s]", fontsize=9.5)
    axes.yaxis.set_major_locator(MaxNLocator(nbins=3, steps=[1, 2, 2.5, 5, 10]))
    axes.spines[["top", "right"]].set_visible(False)
    xs, ys = zip(*clock.points, strict=True)
    axes.plot(xs, ys, color=INK, linewidth=1.3, label=f"clock {clock.name}")
    labels = clock_labels(clock)
    for value, text, colour in labels:
        axes.axhline(value, color=colour, linestyle=(0, (5, 2)), linewidth=1.2, label=f"limit {text}")
    write_beside(axes, labels, CLOCK_IN)
