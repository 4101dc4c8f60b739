"""The heading of a timeline: the verdict, the source of the recording, and the colour legend."""

from __future__ import annotations

from dataclasses import dataclass

from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from end_effector_hal.recording import RunInfo, Story
from end_effector_lab.figures._labels import height_of, packed, width_of, wrapped
from end_effector_lab.figures._style import FILLS, MUTED, plain

from ._page import EDGE_IN, WIDTH_IN

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
    simulated = bool(info.scenario) if info.simulated is None else info.simulated
    parts = [
        f"scenario {plain(info.scenario)}" if info.scenario else "",
        "" if info.seed is None else f"seed {info.seed}",
        f"description {plain(info.description)} {plain(info.hash[:8])}"
        if info.description or info.hash
        else "",
        f"end-effector-hal {plain(info.version, 20)}" if info.version else "",
        f"ROS {info.ros_generation or ''}" if info.ros else "without ROS",
        plain(info.started[:16].replace("T", " ")),
        "simulated" if simulated else "not simulated",
    ]
    return [part.strip() for part in parts if part]


def draw_heading(figure: Figure, heading: Heading, left: float) -> None:
    """Draw title, reason, subtitle and legend, ``left`` inches from the edge."""
    height = figure.get_figheight()
    x = left / WIDTH_IN
    figure.text(
        x,
        1 - EDGE_IN / height,
        "\n".join(heading.title),
        va="top",
        fontsize=TITLE,
        fontweight="bold",
        linespacing=1.25,
    )
    figure.text(
        x,
        1 - heading.because_at / height,
        "\n".join(heading.because),
        va="top",
        fontsize=BECAUSE,
        linespacing=1.25,
    )
    figure.text(
        x,
        1 - heading.subtitle_at / height,
        "\n".join(heading.subtitle),
        va="top",
        fontsize=SUBTITLE,
        color=MUTED,
        linespacing=1.25,
    )
    y = heading.legend_at
    for name, colour in FILLS.items():
        box = Rectangle(
            (left / WIDTH_IN, 1 - (y + 0.06) / height),
            _SWATCH_IN / WIDTH_IN,
            0.12 / height,
            facecolor=colour,
            linewidth=0,
        )
        box.set(transform=figure.transFigure, label=name)
        figure.add_artist(box)
        left += _SWATCH_IN + 0.08
        figure.text(left / WIDTH_IN, 1 - y / height, name, fontsize=LEGEND, va="center_baseline")
        left += width_of(name, LEGEND) + 0.22
