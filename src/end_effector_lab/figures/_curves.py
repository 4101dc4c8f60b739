"""Step curves with offsets, and where the names of their states go; everything in inches."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise, product

from end_effector_lab.figures._labels import Box, Point, Sheet, height_of, width_of
from end_effector_lab.figures._lanes import Lane, Segment
from end_effector_lab.figures._style import kind_of

UNIT_IN = 0.2
TEXT = 8.5
COLOURS = ("#0072b2", "#1d2733", "#d55e00", "#009e73", "#aa4499", "#b08800", "#4f9fd4")
_FOOT, _BETWEEN = 1.2, 2.0
"""Units below the lowest curve and between two, for the names."""

_AGAIN_IN = 0.15
"""Where a state comes again within so little room, there is no place for its name either."""

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
"""(whether the leader may cross a curve, offset), the best first."""


@dataclass(frozen=True)
class Curve:
    """One element: its value plus ``offset`` is drawn."""

    lane: Lane
    title: str
    colour: str
    offset: float

    def level(self, segment: Segment) -> float:
        """In units from the foot of the figure."""
        return self.offset + int(segment.state)


@dataclass(frozen=True)
class Name:
    """The name of a state: the middle of its words, and the leader where they stand further away."""

    curve: Curve
    segment: Segment
    middle: Point
    leader: tuple[Point, Point] | None


def curves_of(lanes: list[Lane]) -> tuple[list[Curve], float]:
    """Commands on top, then the end-effector, then the actuators in sequence order; and their units."""
    end_effector, command, *actuators = lanes
    titles = ["Supervisor command", "End-effector", *(lane.title for lane in actuators)]
    curves: list[Curve] = []
    foot = _FOOT
    for index, lane in reversed(list(enumerate([command, end_effector, *actuators]))):
        values = [int(segment.state) for segment in lane.segments]
        curves.append(Curve(lane, titles[index], COLOURS[index % len(COLOURS)], foot - min(values)))
        foot += max(max(values) - min(values), 1) + _BETWEEN
    return curves[::-1], foot


def place_names(curves: list[Curve], start_s: float, per_second: float, frame: Box) -> list[Name]:
    """A place for the name at each transition, so that it stands on no other and on no curve.

    Just after the transition and above the new level; where that is taken, further away with a leader; where
    there is no room, nowhere.

    Args:
        curves: all of them.
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
        for segment in sorted(curve.lane.segments, key=lambda s: (kind_of(s.state) != "error", s.start_s)):
            x = (segment.start_s - start_s) * per_second
            spot = (int(segment.state), int(x / _AGAIN_IN))
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
