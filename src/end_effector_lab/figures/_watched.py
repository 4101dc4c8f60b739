"""Lanes of switches, the e-stop and the parts of a violated requirement; plots of its clocks."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from end_effector_hal.kinds import SwitchMeaning
from end_effector_hal.recording import RunInfo, SwitchesLog, Watched
from end_effector_hal.vocabulary import display_name

from ._labels import BESIDE_SIZE, width_of, write_beside
from ._lanes import Lane, segments_of
from ._style import INK, MUTED, OPEN, WRONG, ShownLevel, ShownValue, plain

SWITCH_IN, _STEP_IN = 0.26, 0.04
_MOST = 64
_E_STOP = {level: ShownLevel(words, level, proven) for level, words, proven in (
    (None, "not known", ""), (False, "open", OPEN), (True, "closed", ""),
)}  # fmt: skip


def switch_lanes(log: SwitchesLog | None, info: RunInfo, end_s: float) -> list[Lane]:
    """Return lanes of the switches whose meaning the run gives, in the order of the actuators, then the e-stop's.

    Changes after ``end_s`` are omitted.
    """
    rows = tuple(row for row in log.rows if row[0] <= end_s) if log is not None else ()
    if log is None or not rows:
        return []
    log = replace(log, rows=rows)
    named = [name for name in log.channels if name in info.switches]
    lanes = [_switch_lane(log, name, info, end_s) for name in named[:_MOST]]
    if lanes:
        more = f" ({len(lanes)} of {len(named)})" if len(named) > len(lanes) else ""
        lanes[0].caption = f"switches{more}: the line is the level, the colour what it proves by itself"
    if info.e_stop in log.channels:
        levels = [_E_STOP[level] for level in log.levels(info.e_stop)]
        stop = Lane("e-stop", "E-stop", segments_of(log.times_s, levels, end_s), bar_in=SWITCH_IN)
        stop.caption = "" if lanes else "the line is the level: up while the e-stop is closed"
        lanes.append(stop)
    return lanes


def last_switched_s(log: SwitchesLog | None, info: RunInfo) -> float:
    """Return when a level with a lane last changed, s; 0: never, or there is no such lane."""
    if log is None:
        return 0.0
    columns = [log.levels(name) for name in log.channels if name in info.switches or name == info.e_stop]
    levels = list(zip(*columns, strict=True))
    changes = (log.times_s[at] for at in range(len(levels) - 1, 0, -1) if levels[at] != levels[at - 1])
    return next(changes, 0.0)


def _switch_lane(log: SwitchesLog, name: str, info: RunInfo, end_s: float) -> Lane:
    meaning = SwitchMeaning(*(str(info.switches[name].get(key) or "")[:40] for key in ("on", "off")))
    shown = {
        level: ShownLevel(
            meaning.words(level), level, (meaning.off, meaning.on)[level] if level is not None else ""
        )
        for level in (None, False, True)
    }
    segments = segments_of(log.times_s, [shown[level] for level in log.levels(name)], end_s)
    return Lane(f"switch {name}", display_name(name), segments, bar_in=SWITCH_IN)


def draw_steps(axes: Axes, lane: Lane, top: float) -> None:
    """Draw the levels of a lane whose bar begins at ``top``, inches downwards; on is up, and unknown is a gap."""
    xs: list[float] = []
    ys: list[float] = []
    for segment in lane.segments:
        if not isinstance(segment.state, ShownLevel):
            return
        level = segment.state.level
        y = {True: top + _STEP_IN, False: top + lane.bar_in - _STEP_IN, None: float("nan")}[level]
        xs += [segment.start_s, segment.end_s]
        ys += [y, y]
    axes.plot(xs, ys, color=INK, linewidth=1.1, zorder=4.1, label=f"{lane.name}: level", clip_on=False)


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
