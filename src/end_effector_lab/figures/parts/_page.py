"""The dimensions of a timeline: inches, seconds, and the names at the left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import PressuresLog, StatesLog
from end_effector_lab.figures._labels import width_of, wrapped
from end_effector_lab.figures._style import plain

WIDTH_IN, EDGE_IN = 12.27, 0.2
NAME = 10.5
_TITLE_IN = 1.7


@dataclass(frozen=True)
class Page:
    """The dimensions of one figure, in inches from the upper left corner; time in seconds."""

    start_s: float
    end_s: float
    left: float
    width: float

    def x(self, at_s: float) -> float:
        """Convert a time to inches from the left end of the lanes."""
        return (at_s - self.start_s) / (self.end_s - self.start_s) * self.width

    def seconds(self, x: float) -> float:
        return self.start_s + x / self.width * (self.end_s - self.start_s)


def need_rows(log: StatesLog) -> None:
    """Raise UsageError for a recording without a row."""
    if not log.rows:
        raise UsageError("This recording holds no row, so there is nothing to draw.", where=log.source)


def span_of(log: StatesLog) -> tuple[float, float]:
    """Return start and end of a figure, seconds; it starts at zero unless the first row is far from it."""
    first, last = log.rows[0].time_s, log.rows[-1].time_s
    return 0.0 if first <= 0.25 * last else first, last


def page_of(
    log: StatesLog,
    pressures: PressuresLog | None,
    words_in: float,
    more_names: Sequence[str] = (),
    switched_s: float = 0.0,
) -> Page:
    """Return the page for a recording.

    Args:
        log: its states.
        pressures: the pressures, drawn below the states.
        words_in: width of the text right of the plots, inches.
        more_names: names of further lanes.
        switched_s: the last change in the lanes of switches; an opening e-stop may change no state.
    """
    start, last = span_of(log)
    # a counterexample may last some milliseconds
    room = max(0.04 * (last - start), min(0.1, 0.3 * (last - start) or 0.1))
    end = last + room
    longest = end + 0.5 * (end - start)
    if pressures is not None and pressures.samples:
        end = max(end, min(pressures.times_s[-1], longest))
    if switched_s > end:
        end = min(switched_s + room, longest)
    titles = [*(name.replace("_", " ") for name in (*log.actuators, "end_effector")), *more_names]
    names = [line for title in titles for line in _lane_title(title)]
    left = max(width_of(name, NAME) for name in names) + 0.35
    right = max(words_in + 0.25, 0.4)
    return Page(start, end, max(left, 1.2), WIDTH_IN - max(left, 1.2) - right)


def _lane_title(title: str) -> list[str]:
    """Split a title into at most two lines; a third would overlap the lane below."""
    if width_of(title, NAME) > _TITLE_IN:  # ``evidence[bottom_vacuum]`` has no other place to be parted
        title = title.replace("[", " [").replace("(", " (")
    first, *others = wrapped(title, NAME, "normal", _TITLE_IN)
    rest = plain(" ".join(others), 24)
    return [plain(first, 24), rest] if rest else [plain(first, 24)]


def write_name(axes: Axes, page: Page, title: str, y: float) -> None:
    """Write a name at the left of a lane; ``y`` in inches."""
    axes.text(page.seconds(-0.1), y, "\n".join(_lane_title(title)), ha="right", va="center", fontsize=NAME)
