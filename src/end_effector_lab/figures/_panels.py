"""Pressures below the lanes, with the range in which they confirm."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from end_effector_hal.kinds import recorded_kind
from end_effector_hal.recording import PressuresLog, RunInfo
from end_effector_hal.vocabulary import display_name

from ._labels import height_of, spread, width_of
from ._style import BAND, BAND_INK, CURVES, SUPPLY

HEIGHT_IN = 1.1
TEXT = 9.0
_GAP_S = 1.5
"""Steady pressures are written twice a second, so a longer gap means that nothing was received."""


@dataclass(frozen=True)
class PanelCurve:
    """One channel, kPa gauge; NaN where there was none."""

    title: str
    colour: str
    times_s: list[float]
    kpa: list[float]

    @property
    def last(self) -> float:
        """The last value, kPa."""
        return next(value for value in reversed(self.kpa) if not math.isnan(value))


@dataclass
class Panel:
    """Curves that share an axis; ``bands`` are what confirms: (kPa, whose)."""

    title: str
    below: bool
    curves: list[PanelCurve] = field(default_factory=list)
    bands: dict[float, list[str]] = field(default_factory=dict)

    def range_kpa(self) -> tuple[float, float]:
        """What the axis shows: everything measured, zero, and some of the accepted range."""
        values = [value for curve in self.curves for value in curve.kpa if not math.isnan(value)]
        values += [limit - 15 if self.below else limit * 1.12 for limit in self.bands]
        low, high = min(0.0, *values), max(0.0, *values)
        room = max(0.07 * (high - low), 1.0)
        return low - room, high + room

    def labels(self) -> list[tuple[float, str, str]]:
        """(kPa, words, colour) at the right end."""
        low, high = self.range_kpa()
        found = [(curve.last, curve.title, curve.colour) for curve in self.curves]
        for limit, whose in self.bands.items():
            name = "confirmed" if len(self.bands) == 1 else " and ".join(whose)
            sign, edge = ("≤", low) if self.below else ("≥", high)
            text = f"{name}\n{sign} {limit:g} kPa".replace("-", "−")
            found.append(((limit + edge) / 2, text, BAND_INK))
        return found


def panels_of(pressures: PressuresLog | None, info: RunInfo, actuators: tuple[str, ...]) -> list[Panel]:
    """Vacuums in one panel, pressures above ambient in another; a channel without any value is left out."""
    below, above = Panel("vacuum\n[kPa]", below=True), Panel("pressure\n[kPa]", below=False)
    colours = {name: CURVES[index % len(CURVES)] for index, name in enumerate(actuators)}
    for channel in pressures.channels if pressures else ():
        assert pressures is not None
        curve = pressures.curve(channel)
        values = [value for value in curve if value is not None]
        if not values:
            continue
        owner = _owner(channel, info, actuators)
        panel = below if _is_below_ambient(owner, values, info) else above
        title, colour = (display_name(owner), colours[owner]) if owner else (display_name(channel), SUPPLY)
        panel.curves.append(PanelCurve(title, colour, *_broken(pressures.times_s, curve)))
        limit = info.limits.get(owner or "", {}).get("confirmed_kpa")
        if owner and isinstance(limit, int | float) and math.isfinite(limit) and 0 < limit < 1e4:
            panel.bands.setdefault(-limit if panel.below else limit, []).append(display_name(owner))
    return [panel for panel in (below, above) if panel.curves]


def _owner(channel: str, info: RunInfo, actuators: tuple[str, ...]) -> str | None:
    """The actuator that a channel proves; without run.json the one that has the channel's name in its own."""
    listed = [name for name in actuators if info.limits.get(name, {}).get("channel") == channel]
    named = [name for name in actuators if channel == name or channel in name.split("_")]
    return next(iter(listed + named), None)


def _is_below_ambient(owner: str | None, values: list[float], info: RunInfo) -> bool:
    if owner is not None:
        return recorded_kind(owner, info.actuators).below_ambient
    return max(values) < 20


def _broken(times_s: tuple[float, ...], values: tuple[float | None, ...]) -> tuple[list[float], list[float]]:
    """The curve with a hole wherever nothing valid was received."""
    xs: list[float] = []
    ys: list[float] = []
    for time_s, value in zip(times_s, values, strict=True):
        if xs and time_s - xs[-1] > _GAP_S:
            xs.append(xs[-1])
            ys.append(math.nan)
        xs.append(time_s)
        ys.append(math.nan if value is None else value)
    return xs, ys


def labels_width(panels: list[Panel]) -> float:
    """Inches that the words at the right need."""
    texts = [line for panel in panels for _, text, _ in panel.labels() for line in text.split("\n")]
    return max((width_of(text, TEXT) for text in texts), default=0.0)


def draw_panel(axes: Axes, panel: Panel) -> None:
    """Curves, accepted ranges, and their words at the right."""
    low, high = panel.range_kpa()
    axes.set_ylim(low, high)
    axes.set_ylabel(panel.title, fontsize=9.5)
    axes.yaxis.set_major_locator(MaxNLocator(nbins=3, steps=[1, 2, 2.5, 5, 10]))
    axes.spines[["top", "right"]].set_visible(False)
    axes.axhline(0.0, color="#e3e6eb", linewidth=0.8, zorder=0)
    for limit in panel.bands:
        axes.axhspan(*((low, limit) if panel.below else (limit, high)), color=BAND, linewidth=0, zorder=0)
    for curve in panel.curves:
        axes.plot(curve.times_s, curve.kpa, color=curve.colour, linewidth=1.3, label=curve.title)
    labels = panel.labels()
    per_inch = (high - low) / HEIGHT_IN
    heights = [height_of(TEXT) * (text.count("\n") + 1) * per_inch for _, text, _ in labels]
    places = spread([at for at, _, _ in labels], heights, low, high)
    for place, (_, text, colour) in zip(places, labels, strict=True):
        axes.annotate(
            text,
            (1.0, place),
            xycoords=("axes fraction", "data"),
            xytext=(6, 0),
            textcoords="offset points",
            color=colour,
            fontsize=TEXT,
            va="center",
            linespacing=1.15,
            annotation_clip=False,
        )
