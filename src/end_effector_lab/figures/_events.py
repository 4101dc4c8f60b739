"""The rows of events: a mark and a text for each moment of the story."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

from matplotlib.axes import Axes

from end_effector_hal.recording import Moment

from ._labels import Box, Sheet, height_of, width_of
from ._page import Page, write_name
from ._style import MARKERS, plain

TEXT = 9.5
ROW_IN = height_of(TEXT) + 0.06
MARK_IN = 0.13
FOOT_IN = 0.3
"""Distance from the lowest row down to the lanes, inches."""

LONGEST_ROWS = 7
_FIRST = ("disturbed", "abort", "lost", "missed", "timeout", "alarm", "gripped", "command")


@dataclass(frozen=True)
class Event:
    """A moment with its place.

    Row 0 is the lowest; ``left``: the text is left of the mark; ``text`` is empty if it has no room.
    """

    moment: Moment
    row: int
    x: float
    left: bool
    text: str

    @property
    def weight(self) -> str:
        return weight_of(self.moment)


def weight_of(moment: Moment) -> str:
    """Return the font weight: bold for final failures and disturbances."""
    return "bold" if moment.kind in ("abort", "lost", "disturbed") else "normal"


def place_events(moments: Sequence[Moment], x_of: Callable[[float], float], right_in: float) -> list[Event]:
    """Find a place for each moment, so that no text covers another text or the line of another mark.

    If there is no room for all texts, they become shorter; then texts are omitted, commands first, errors last.

    Args:
        moments: in order of time.
        x_of: converts seconds to inches from the left end of the lanes.
        right_in: right limit of the text, inches.
    """
    moments = _together(moments, x_of)
    best: tuple[list[int], list[Event]] | None = None
    for number in range(len(_FIRST), 0, -1):
        silent: set[int] = set()
        for _ in range(_TRIALS):
            spoken = [m for m in moments if m.kind in _FIRST[:number] and id(m) not in silent]
            for wording in (_full, _short):
                events = _place_all(moments, spoken, wording, x_of, right_in)
                if best is None or _worth(events) > best[0]:
                    best = _worth(events), events
                wanting = {id(m) for m in spoken} - {id(event.moment) for event in events if event.text}
                if not wanting and len(spoken) == len(moments):
                    return sorted(events, key=lambda event: event.moment.time_s)
            silent |= {id(m) for m in spoken if id(m) in wanting and m.kind == _FIRST[number - 1]}
    return sorted(best[1] if best else [], key=lambda event: event.moment.time_s)


_TRIALS = 3
"""Number of placements; before each retry, texts of the least important kind that had no room are dropped."""


def _worth(events: Sequence[Event]) -> list[int]:
    """Return the number of texts of each kind, the most important kind first."""
    told = Counter(event.moment.kind for event in events if event.text)
    return [told[kind] for kind in _FIRST]


def _together(moments: Sequence[Moment], x_of: Callable[[float], float]) -> list[Moment]:
    """Merge moments on one mark: commands into one text, alarms into the first and the count of the rest."""
    found: list[list[Moment]] = []
    for moment in moments:
        last = found[-1] if found else []
        near = bool(last) and x_of(moment.time_s) - x_of(last[0].time_s) < MARK_IN
        if near and last[0].kind == moment.kind and moment.kind in ("command", "alarm"):
            last.append(moment)
        else:
            found.append([moment])
    return [replace(group[0], text=_words(group)) for group in found]


def _words(group: Sequence[Moment]) -> str:
    first = group[0]
    if first.kind != "alarm":
        return ", ".join(moment.text for moment in group)
    return plain(first.text, _LONGEST) + (f" +{len(group) - 1}" if len(group) > 1 else "")


_LONGEST = 48
"""Largest number of characters of an alarm, which may be a long foreign sentence."""


def _full(moment: Moment) -> str:
    return moment.text


def _short(moment: Moment) -> str:
    """Shorten: ``Cylinder time-out 2/3`` -> ``Cylinder 2/3``, ``Cylinder time-out 3/3 – abort`` -> ``abort``."""
    return moment.text.replace("time-out ", "") if moment.kind == "timeout" else moment.text.split(" – ")[-1]


def _place_all(
    moments: Sequence[Moment],
    worded: Sequence[Moment],
    wording: Callable[[Moment], str],
    x_of: Callable[[float], float],
    right_in: float,
) -> list[Event]:
    """Place marks for all moments, and texts for some."""
    sheet, told = Sheet(), {id(moment) for moment in worded}
    events = [_mark(moment, x_of(moment.time_s), sheet) for moment in moments if id(moment) not in told]
    spoken = [(m, x_of(m.time_s), wording(m)) for m in worded]
    inside = [place for place in spoken if place[1] + _width(place[0], place[2]) <= right_in]
    beyond = [place for place in spoken if place[1] + _width(place[0], place[2]) > right_in]
    # from the last to the first: the line of an earlier mark then passes left of all words below it; words that
    # must stand left of their mark go above the earlier marks, so they come after these
    return events + [_place(moment, x, text, right_in, sheet) for moment, x, text in (*inside[::-1], *beyond)]


def _width(moment: Moment, text: str) -> float:
    """Return the width of a text with its mark, inches from the middle of the mark."""
    return width_of(text, TEXT, weight_of(moment)) + MARK_IN / 2 + 0.08


def _place(moment: Moment, x: float, text: str, right_in: float, sheet: Sheet) -> Event:
    width, half = _width(moment, text), MARK_IN / 2
    for left, row in product((False, True), range(LONGEST_ROWS)):
        low, high = row * ROW_IN, (row + 1) * ROW_IN - 0.02
        box = Box(x - width, low, x + half, high) if left else Box(x - half, low, x + width, high)
        line = ((x, -FOOT_IN), (x, low))
        within = box.x0 >= (0.0 if left else -MARK_IN) and box.x1 <= right_in
        if within and sheet.free(box) and sheet.free_line(*line):
            sheet.take(box)
            sheet.take_line(*line)
            return Event(moment, row, x, left, text)
    return _mark(moment, x, sheet)


def _mark(moment: Moment, x: float, sheet: Sheet) -> Event:
    """Place a mark without text: text must not cover it, but lines of other marks may."""
    sheet.take_line((x - MARK_IN / 2, ROW_IN / 2), (x + MARK_IN / 2, ROW_IN / 2))
    return Event(moment, 0, x, False, "")


_MOST = 40
"""Largest number of events for which the lines of events without text are drawn; more would hide the lanes."""


def lined(events: Sequence[Event]) -> list[Event]:
    """Return the events that get a line through lanes and pressures: all, or only those with a text if there are too
    many.
    """
    return [event for event in events if event.text or len(events) <= _MOST]


def line_of(event: Event) -> dict[str, Any]:
    """Return the style of the line through lanes and pressures; fainter for an event without text."""
    colour, alpha = MARKERS[event.moment.kind][1], 0.75 if event.text else 0.35
    return {"color": colour, "linewidth": 0.9, "linestyle": (0, (4, 3)), "alpha": alpha}


def draw_events(axes: Axes, page: Page, events: Sequence[Event]) -> None:
    """Draw marks and texts; zero of ``y`` is the foot of the lowest row, inches downwards."""
    write_name(axes, page, "Events", -ROW_IN / 2)
    for event in events:
        marker, colour = MARKERS[event.moment.kind]
        y = -(event.row + 0.5) * ROW_IN
        size = 11 if marker == "*" else 8
        axes.plot(
            [event.moment.time_s],
            [y],
            marker=marker,
            color=colour,
            markersize=size,
            markeredgewidth=0,
            clip_on=False,
            zorder=4 if event.text else 3,  # a mark whose words stand beside it is not hidden
        )
        beside = -MARK_IN / 2 - 0.03 if event.left else MARK_IN / 2 + 0.03
        if event.text:
            axes.text(
                page.seconds(event.x + beside),
                y,
                event.text,
                ha="right" if event.left else "left",
                va="center_baseline",
                color=colour,
                fontsize=TEXT,
                fontweight=event.weight,
                label="event",
            )
