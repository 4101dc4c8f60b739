"""The events of a timeline as they are drawn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes

from end_effector_lab.figures import _events
from end_effector_lab.figures._events import Event
from end_effector_lab.figures._page import Page, write_name
from end_effector_lab.figures._style import MARKERS

_MOST = 40
"""More events than this, and the lines of those without words would hide the lanes."""


def lined(events: Sequence[Event]) -> list[Event]:
    """The events whose line runs through lanes and pressures."""
    return [event for event in events if event.text or len(events) <= _MOST]


def line_of(event: Event) -> dict[str, Any]:
    """Through lanes and pressures; fainter where there are so many that not all have words."""
    colour, alpha = MARKERS[event.moment.kind][1], 0.75 if event.text else 0.35
    return {"color": colour, "linewidth": 0.9, "linestyle": (0, (4, 3)), "alpha": alpha}


def draw_events(axes: Axes, page: Page, events: Sequence[Event]) -> None:
    """Marks and words; zero of ``y`` is the foot of the lowest row, inches downwards."""
    write_name(axes, page, "Events", -_events.ROW_IN / 2)
    for event in events:
        marker, colour = MARKERS[event.moment.kind]
        y = -(event.row + 0.5) * _events.ROW_IN
        size = 11 if marker == "*" else 8
        axes.plot(
            [event.moment.time_s],
            [y],
            marker=marker,
            color=colour,
            markersize=size,
            markeredgewidth=0,
            clip_on=False,
        )
        beside = -_events.MARK_IN / 2 - 0.03 if event.left else _events.MARK_IN / 2 + 0.03
        if event.text:
            axes.text(
                page.seconds(event.x + beside),
                y,
                event.text,
                ha="right" if event.left else "left",
                va="center_baseline",
                color=colour,
                fontsize=_events.TEXT,
                fontweight=event.weight,
                label="event",
            )
