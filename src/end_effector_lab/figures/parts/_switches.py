"""Lanes of switches: the level as a step, and in words and colour what it proves."""

from __future__ import annotations

from matplotlib.axes import Axes

from end_effector_hal.kinds import SwitchMeaning
from end_effector_hal.recording import RunInfo, SwitchesLog
from end_effector_hal.vocabulary import display_name
from end_effector_lab.figures._style import INK, ShownLevel

from ._lanes import Lane, segments_of

SWITCH_IN, _STEP_IN = 0.26, 0.04
_MOST = 64


def switch_lanes(log: SwitchesLog | None, info: RunInfo, end_s: float) -> list[Lane]:
    """Of those of which the run says what they prove, in the order of the actuators."""
    if log is None or not log.rows:
        return []
    named = [name for name in log.channels if name in info.switches]
    lanes = [_lane(log, name, info, end_s) for name in named[:_MOST]]
    if lanes:
        more = f" ({len(lanes)} of {len(named)})" if len(named) > len(lanes) else ""
        lanes[0].caption = f"switches{more}: the line is the level, the colour what it proves by itself"
    return lanes


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
    """The levels of a lane whose bar begins at ``top``, inches downwards; on is up, and what is not known is a gap."""
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
