"""States as lanes: their segments, the text in and beside them, and their drawing."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import product
from math import inf

from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from end_effector_hal.kinds import recorded_kind
from end_effector_hal.recording import ChangerRow, PressuresLog, RunInfo, StatesLog
from end_effector_hal.vocabulary import INACTIVE, EndEffectorState, TableState, display_name

from ._labels import Box, Point, Sheet, first_fitting, height_of, width_of
from ._page import Page, write_name
from ._style import DPI, INK, MUTED, Shown, ShownLevel, fill_of, ink_of, kind_of, wordings

BAR_IN = 0.44
CAPTION_IN = 0.3
TEXT, SMALL = 9.0, 7.5
ROW_IN = height_of(TEXT) + 0.03
GAP_IN = 0.09
LEADER_IN = 0.07
LONGEST_ROWS = 3
THIN_IN = 0.02
ERROR_IN = 0.05
"""Least width of a segment that is an error, inches; `THIN_IN` for all others."""


@dataclass(frozen=True)
class Segment:
    """A state and its time; ``releasing``: deactivated, but its sensor does not show that yet."""

    start_s: float
    end_s: float
    state: Shown
    releasing: bool = False

    @property
    def kind(self) -> str:
        """Key of the colours; empty: nothing to show."""
        return "releasing" if self.releasing else kind_of(self.state)

    @property
    def level(self) -> int:
        """Integer of Table II; 0 for a value that is not in it."""
        return int(self.state) if isinstance(self.state, TableState) else 0


@dataclass(frozen=True)
class Inside:
    """Text in a bar, centred at ``x`` inches from its left end; ``size`` in points."""

    segment: Segment
    text: str
    x: float
    size: float


@dataclass(frozen=True)
class Beside:
    """Text below a bar whose segment is too short for it; inches, y downwards from the bar's lower edge."""

    segment: Segment
    text: str
    box: Box
    start: Point
    end: Point


@dataclass
class Lane:
    """One element over time; ``ruled``: a thin line is drawn below it."""

    name: str
    title: str
    segments: list[Segment]
    inside: list[Inside] = field(default_factory=list)
    beside: list[Beside] = field(default_factory=list)
    caption: str = ""
    bar_in: float = BAR_IN
    ruled: bool = False

    @property
    def bar_at(self) -> float:
        """Start of the bar, inches from the upper edge of the lane."""
        return CAPTION_IN if self.caption else 0.0

    @property
    def height_in(self) -> float:
        """Height of caption, bar, text below, and gap, inches."""
        lowest = max((words.box.y1 for words in self.beside), default=0.0)
        return self.bar_at + self.bar_in + max(lowest, 0.0) + GAP_IN


def lanes_of(log: StatesLog, info: RunInfo, end_s: float) -> list[Lane]:
    """Return lanes of end-effector, command and actuators, merged into segments of one state."""
    times = log.times_s
    columns: list[tuple[str, str, list[Shown]]] = [
        ("end_effector", "End-effector", [row.end_effector for row in log.rows]),
        ("command", "Command", [row.command for row in log.rows]),
    ]
    for index, name in enumerate(log.actuators):
        table = recorded_kind(name, info.actuators).states
        columns.append((name, display_name(name), [table(row.actuators[index]) for row in log.rows]))
    return [Lane(name, title, segments_of(times, states, end_s)) for name, title, states in columns]


def all_lanes_of(
    log: StatesLog,
    info: RunInfo,
    end_s: float,
    pressures: PressuresLog | None,
    changer: Sequence[ChangerRow],
) -> list[Lane]:
    """Return those lanes with the releases of the actuators, and the tool changer's lane."""
    lanes = lanes_of(log, info, end_s)
    for lane in lanes[2:]:
        lane.segments = _with_releases(lane, log, info, pressures)
    if changer:
        rows = ([row.time_s for row in changer], [row.state for row in changer])
        lanes.append(Lane("tool_changer", "Tool changer", segments_of(*rows, end_s)))
    return lanes


def _with_releases(
    lane: Lane, log: StatesLog, info: RunInfo, pressures: PressuresLog | None
) -> list[Segment]:
    """Return the segments; those after a deactivation are split at the time when the feedback is gone."""
    found: list[Segment] = []
    for segment in lane.segments:
        begun, ended = segment.start_s, segment.end_s
        if found and segment.state == INACTIVE:
            until = min(gone_s(lane.name, begun, log, info, pressures), ended)
            if until > begun:
                found.append(Segment(begun, until, segment.state, releasing=True))
                begun = until
        if begun < ended or segment.start_s == ended:
            found.append(Segment(begun, ended, segment.state))
    return found


def segments_of(times_s: Sequence[float], states: Sequence[Shown], end_s: float) -> list[Segment]:
    """Merge equal states into segments; a state that was left at once has no length and remains."""
    found: list[Segment] = []
    for index, (start_s, state) in enumerate(zip(times_s, states, strict=True)):
        until_s = times_s[index + 1] if index + 1 < len(times_s) else max(end_s, start_s)
        if found and found[-1].state is state:
            found[-1] = Segment(found[-1].start_s, until_s, state)
        else:
            found.append(Segment(start_s, until_s, state))
    return found


def least_width(lane: Lane, segment: Segment, width_in: float) -> float:
    """Return the least width of a segment in a lane of ``width_in`` inches, so that a state of no length is visible.

    Errors are the widest, unless there are so many that they would hide everything else.
    """
    if segment.kind != "error":
        return THIN_IN
    errors = sum(other.kind == "error" for other in lane.segments)
    return min(ERROR_IN, max(width_in / (8 * errors), 0.01))


def write_lane(lane: Lane, x_of: Callable[[float], float], width_in: float, avoid: Sequence[float]) -> None:
    """Find places for the text of a lane: inside a segment if it fits, else below it with a leader.

    Args:
        lane: the lane; its texts are set.
        x_of: converts seconds to inches from the left end of the lane.
        width_in: width of the whole lane.
        avoid: inches at which vertical lines cross the lane.
    """
    outside = []
    for segment in lane.segments:
        left, right = x_of(segment.start_s), x_of(segment.end_s)
        if segment.releasing:
            continue  # Table II has no word for it: the colour says it
        for size in (TEXT, SMALL):
            text = first_fitting(wordings(segment.state), size, right - left - 0.08)
            if text is not None:
                x = _clear(left, right, width_of(text, size), avoid)
                lane.inside.append(Inside(segment, text, x, size))
                break
        else:
            if not isinstance(segment.state, ShownLevel):  # its line says it
                outside.append(segment)
    in_middle = _beside(sorted(outside, key=_rank), x_of, width_in, _MIDDLE)
    # left of their feet, in order of time, more words find a place where short segments follow each other
    to_left = _beside(outside, x_of, width_in, _LEFT)
    lane.beside = to_left if _worth(to_left) > _worth(in_middle) else in_middle


_MIDDLE = ((0.0, -0.35, 0.35, -0.55, 0.55, -0.8, 0.8),)
_LEFT = ((-0.5, -0.6, -0.8), (0.0, 0.5, 0.8))
"""Offsets of the text's middle from the segment's middle, in text widths; each group is tried in every row before the
next.
"""


def _rank(segment: Segment) -> tuple[int, float, float]:
    """Return the sort key: errors first and NONE last, since the last ones may find no room."""
    first = {"error": 0, "": 2}.get(segment.kind, 1)
    return first, segment.start_s - segment.end_s, segment.start_s


def _worth(words: Sequence[Beside]) -> tuple[int, int]:
    kinds = [beside.segment.kind for beside in words]
    return kinds.count("error"), len(kinds) - kinds.count("")


def _beside(
    segments: Sequence[Segment],
    x_of: Callable[[float], float],
    width_in: float,
    shifts: Sequence[Sequence[float]],
) -> list[Beside]:
    sheet = Sheet()
    found = []
    for segment in segments:
        words = _below(segment, x_of, width_in, sheet, shifts)
        if words is not None:
            sheet.take(words.box)
            sheet.take_line(words.start, words.end)
            found.append(words)
    return found


def _clear(left: float, right: float, width: float, avoid: Sequence[float]) -> float:
    """Return a centre for text inside a segment that no event line crosses; else the middle."""
    middle, room = (left + right) / 2, (right - left - width) / 2 - 0.05
    half = width / 2 + 0.04
    shifts = (0.0, *(sign * room * part / 8 for part in range(1, 9) for sign in (-1, 1)))
    for shift in shifts:
        if not any(middle + shift - half < x < middle + shift + half for x in avoid):
            return middle + shift
    return middle


def _below(
    segment: Segment,
    x_of: Callable[[float], float],
    width_in: float,
    sheet: Sheet,
    shifts: Sequence[Sequence[float]],
) -> Beside | None:
    text = segment.state.label
    width = width_of(text, TEXT) + 0.06
    foot = ((x_of(segment.start_s) + x_of(segment.end_s)) / 2, 0.0)
    page = Box(-0.35, 0.0, width_in + 0.3, LEADER_IN + (LONGEST_ROWS + 0.5) * ROW_IN)
    # NONE is not worth a second row
    rows = range(LONGEST_ROWS if segment.kind else 1)
    for row, shift in (place for group in shifts for place in product(rows, group)):
        top = LEADER_IN + row * ROW_IN
        left = foot[0] + shift * width - width / 2
        box = Box(left, top, left + width, top + ROW_IN)
        end = (min(max(foot[0], left + 0.03), left + width - 0.03), top + 0.02)
        if box.within(page) and sheet.free(box) and sheet.free_line(foot, end):
            return Beside(segment, text, box, foot, end)
    return None


_BORDER_IN = 0.06
"""Least width of two neighbouring segments with a white line between them, which would hide narrower ones."""


def draw_lane(axes: Axes, page: Page, lane: Lane, top: float) -> None:
    """Draw bars and text of a lane whose upper edge is at ``top``, inches downwards."""
    if lane.caption:
        place = (page.start_s, top + CAPTION_IN / 2)
        behind = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
        axes.text(
            *place, lane.caption, va="center_baseline", color=MUTED, fontsize=TEXT, bbox=behind, zorder=4
        )
    top += lane.bar_at
    write_name(axes, page, lane.title, top + lane.bar_in / 2)
    before = 0.0
    seen: set[tuple[Shown, bool, int]] = set()
    for segment in lane.segments:
        width = page.x(segment.end_s) - page.x(segment.start_s)
        least = least_width(lane, segment, page.width)
        spot = (segment.state, segment.releasing, round(page.x(segment.start_s) * DPI))
        # in a long recording thousands of short states fall on one column of pixels
        if width >= least or spot not in seen:
            _draw_bar(axes, page, lane, segment, top, least)
        seen.add(spot)
        if min(width, before) > _BORDER_IN:
            axes.plot(
                [segment.start_s] * 2, [top, top + lane.bar_in], color="white", linewidth=1.6, zorder=2.1
            )
        before = width
    for inside in lane.inside:
        _write_inside(axes, page, inside, top + lane.bar_in / 2)
    for beside in lane.beside:
        _write_beside(axes, page, beside, top + lane.bar_in)


def _draw_bar(axes: Axes, page: Page, lane: Lane, segment: Segment, top: float, least: float) -> None:
    left, right = page.x(segment.start_s), page.x(segment.end_s)
    error = segment.kind == "error"
    zorder = 2.0
    if right - left < least:
        middle, half = (left + right) / 2, least / 2
        left, right = middle - half, middle + half
        zorder = 2.3 if error else 2.2
    bar = Rectangle((page.seconds(left), top), page.seconds(right) - page.seconds(left), lane.bar_in)
    bar.set(facecolor=fill_of(segment.kind), linewidth=0, clip_on=False, zorder=zorder)
    bar.set_label(f"{lane.name}: {segment.state.label}{' (releasing)' if segment.releasing else ''}")
    axes.add_patch(bar)


def _write_inside(axes: Axes, page: Page, inside: Inside, y: float) -> None:
    axes.text(
        page.seconds(inside.x),
        y,
        inside.text,
        ha="center",
        va="center_baseline",
        color=ink_of(inside.segment.kind),
        fontsize=inside.size,
        zorder=4,
        label="inside",
        # a line of an event passes behind the words
        bbox={"facecolor": fill_of(inside.segment.kind), "edgecolor": "none", "pad": 1.0},
    )


def _write_beside(axes: Axes, page: Page, beside: Beside, foot: float) -> None:
    kind, box = beside.segment.kind, beside.box
    colour = fill_of(kind) if kind == "error" else INK
    xs = [page.seconds(beside.start[0]), page.seconds(beside.end[0])]
    ys = [foot + beside.start[1], foot + beside.end[1]]
    axes.plot(xs, ys, color=colour, linewidth=0.9, zorder=4, clip_on=False)
    axes.text(
        page.seconds((box.x0 + box.x1) / 2),
        foot + (box.y0 + box.y1) / 2,
        beside.text,
        ha="center",
        va="center_baseline",
        color=colour,
        fontsize=TEXT,
        zorder=5,
        label="beside",
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6},
    )


def gone_s(
    name: str, deactivated_s: float, log: StatesLog, info: RunInfo, pressures: PressuresLog | None
) -> float:
    """Return when the feedback of an actuator was gone: by its pressure, else by the next step of the release.

    The time is infinite if that never happened, and the time of the deactivation if nothing shows it, or if nothing
    was deactivated: a program that starts (OFF) has no active actuators.
    """
    if log.rows[bisect_right(log.times_s, deactivated_s) - 1].end_effector is EndEffectorState.OFF:
        return deactivated_s
    limit = info.limits.get(name, {})
    channel, gone_kpa = limit.get("channel"), limit.get("gone_kpa")
    if pressures is not None and channel in pressures.channels and isinstance(gone_kpa, int | float):
        sign = -1 if recorded_kind(name, info.actuators).below_ambient else 1
        first = max(bisect_right(pressures.times_s, deactivated_s) - 1, 0)
        later = zip(pressures.times_s[first:], pressures.curve(str(channel))[first:], strict=True)
        known = [(at, kpa) for at, kpa in later if kpa is not None]
        if known:
            return next((max(at, deactivated_s) for at, kpa in known if sign * kpa < gone_kpa), inf)
    return _went_on_s(deactivated_s, log)


def _went_on_s(deactivated_s: float, log: StatesLog) -> float:
    """Return when the next actuator was deactivated or RELEASING ended; if not RELEASING, the given time."""
    first = bisect_right(log.times_s, deactivated_s)
    before = log.rows[first - 1]
    if before.end_effector is not EndEffectorState.RELEASING:
        return deactivated_s
    for row in log.rows[first:]:
        switched = any(
            new == INACTIVE != old for old, new in zip(before.actuators, row.actuators, strict=True)
        )
        if switched or row.end_effector is not EndEffectorState.RELEASING:
            return row.time_s
        before = row
    return inf
