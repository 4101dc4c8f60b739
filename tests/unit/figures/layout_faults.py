"""What makes a drawn template hard to read: words on words, lines through words, lines that run together."""

from __future__ import annotations

from itertools import combinations
from math import dist, hypot

from end_effector_lab.figures._automaton_layout import RADIUS, layout_of
from end_effector_lab.figures._labels import Box

CLEAR, APART, TOGETHER = (
    2,
    7,
    45,
)  # pixels: round words; between lines; as long as two may run closer than that


def layout_faults(template):
    """In words; empty: the template reads well."""
    layout = layout_of(template)
    lines = [segment for arrow, _ in layout.arrows for segment in arrow.segments]
    faults = []
    for one, other in combinations(layout.words, 2):
        if one.box.meets(other.box):
            faults.append(f"{one.lines} on {other.lines}")
    for words in layout.words:
        around = Box(words.box.x0 - CLEAR, words.box.y0 - CLEAR, words.box.x1 + CLEAR, words.box.y1 + CLEAR)
        faults += [
            f"{words.lines} on the location at {disc.x, disc.y}"
            for disc in layout.discs
            if around.meets(disc.box)
        ]
        faults += [f"{words.lines} on an edge at {line}" for line in lines if around.meets_line(*line)]
    for arrow, _ in layout.arrows:
        for number, line in enumerate(arrow.segments):
            for disc in layout.discs:
                ends = [arrow.corners[0]] if number == 0 else []
                ends += [arrow.corners[-1]] if number == len(arrow.segments) - 1 else []
                own = any(abs(dist(end, (disc.x, disc.y)) - RADIUS) < 1 for end in ends)
                if not own and _distance((disc.x, disc.y), line) < RADIUS + APART:
                    faults.append(f"an edge through the location at {disc.x, disc.y}")
    for (one, _), (other, _) in combinations(layout.arrows, 2):
        together = max(_together(a, b) for a in one.segments for b in other.segments)
        if together > TOGETHER:
            faults.append(f"two edges run together: {one.corners}, {other.corners}")
    return faults


def _distance(spot, line):
    (x, y), (end_x, end_y) = line
    dx, dy = end_x - x, end_y - y
    length = dx * dx + dy * dy
    along = max(0, min(1, ((spot[0] - x) * dx + (spot[1] - y) * dy) / length)) if length else 0
    return hypot(spot[0] - x - along * dx, spot[1] - y - along * dy)


def _together(line, other):
    """How far a line runs close to another, pixels."""
    (x, y), (end_x, end_y) = line
    parts = max(1, int(dist(*line) / 4))
    longest = run = 0
    for n in range(parts + 1):
        spot = (x + (end_x - x) * n / parts, y + (end_y - y) * n / parts)
        run = run + 1 if _distance(spot, other) < APART else 0
        longest = max(longest, run)
    return longest * dist(*line) / parts
