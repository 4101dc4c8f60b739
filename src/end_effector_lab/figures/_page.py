"""The page of a timeline: its dimensions, and its heading with the verdict, the source and the colours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import PressuresLog, RunInfo, StatesLog, Story

from ._labels import height_of, packed, width_of, wrapped
from ._style import FILLS, MUTED, plain

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
    width_in: float = WIDTH_IN,
) -> Page:
    """Return the page for a recording.

    Args:
        log: its states.
        pressures: the pressures, drawn below the states.
        words_in: width of the text right of the plots, inches.
        more_names: names of further lanes.
        switched_s: the last change in the lanes of switches; an opening e-stop may change no state.
        width_in: width of the figure, inches.
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
    return Page(start, end, max(left, 1.2), width_in - max(left, 1.2) - right)


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


TITLE, BECAUSE, SUBTITLE, LEGEND = 13.5, 10.5, 9.5, 9.5
_LONGEST = 700
_SWATCH_IN = 0.14


@dataclass(frozen=True)
class Heading:
    """Lines of the title, its reason, and the subtitle; positions in inches from the upper edge."""

    title: list[str]
    because: list[str]
    subtitle: list[str]

    @property
    def because_at(self) -> float:
        return EDGE_IN + height_of(TITLE) * len(self.title) + 0.06

    @property
    def subtitle_at(self) -> float:
        return self.because_at + (height_of(BECAUSE) * len(self.because) + 0.06 if self.because else 0.0)

    @property
    def legend_at(self) -> float:
        return self.subtitle_at + height_of(SUBTITLE) * len(self.subtitle) + 0.25

    @property
    def height_in(self) -> float:
        return self.legend_at + 0.3


def heading_of(story: Story, info: RunInfo, width: float) -> Heading:
    """Return the heading of a recording; no line is wider than ``width`` inches."""
    title = wrapped(story.verdict, TITLE, "bold", width)
    because = wrapped(plain(info.because, _LONGEST), BECAUSE, "normal", width) if info.because else []
    return Heading(title, because, packed(sources(info), "  ·  ", SUBTITLE, "normal", width))


def sources(info: RunInfo) -> list[str]:
    """Return the known facts about the origin of the recording."""
    if info == RunInfo():
        return ["no run.json: source unknown"]
    parts = [
        f"scenario {plain(info.scenario)}" if info.scenario else "",
        "" if info.seed is None else f"seed {info.seed}",
        f"description {plain(info.description)} {plain(info.hash[:8])}"
        if info.description or info.hash
        else "",
        f"end-effector-hal {plain(info.version, 20)}" if info.version else "",
        f"ROS {info.ros_generation or ''}" if info.ros else "without ROS",
        plain(info.started[:16].replace("T", " ")),
        "simulated" if info.is_simulated else "not simulated",
    ]
    return [part.strip() for part in parts if part]


def draw_heading(figure: Figure, heading: Heading, left: float) -> None:
    """Draw title, reason, subtitle and legend, ``left`` inches from the edge."""
    width, height = figure.get_size_inches()
    for lines, at, style in (
        (heading.title, EDGE_IN, {"fontsize": TITLE, "fontweight": "bold"}),
        (heading.because, heading.because_at, {"fontsize": BECAUSE}),
        (heading.subtitle, heading.subtitle_at, {"fontsize": SUBTITLE, "color": MUTED}),
    ):
        figure.text(left / width, 1 - at / height, "\n".join(lines), va="top", linespacing=1.25, **style)
    y = heading.legend_at
    for name, colour in FILLS.items():
        box = Rectangle(
            (left / width, 1 - (y + 0.06) / height),
            _SWATCH_IN / width,
            0.12 / height,
            facecolor=colour,
            linewidth=0,
        )
        box.set(transform=figure.transFigure, label=name)
        figure.add_artist(box)
        left += _SWATCH_IN + 0.08
        figure.text(left / width, 1 - y / height, name, fontsize=LEGEND, va="center_baseline")
        left += width_of(name, LEGEND) + 0.22
