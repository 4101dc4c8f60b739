"""Lanes of switches and of the e-stop: the level as a step, and its meaning as text and colour."""

from __future__ import annotations

from dataclasses import replace

from matplotlib.axes import Axes

from end_effector_hal.kinds import SwitchMeaning
from end_effector_hal.recording import RunInfo, SwitchesLog
from end_effector_hal.vocabulary import display_name
from end_effector_lab.figures._style import INK, OPEN, ShownLevel

from ._lanes import Lane, segments_of

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
    lanes = [_lane(log, name, info, end_s) for name in named[:_MOST]]
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


def _lane(log: SwitchesLog, name: str, info: RunInfo, end_s: float) -> Lane:
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
