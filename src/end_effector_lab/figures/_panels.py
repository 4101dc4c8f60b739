"""Plots of pressures below the lanes, with the range in which they confirm."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from end_effector_hal.kinds import recorded_kind
from end_effector_hal.recording import PressuresLog, RunInfo
from end_effector_hal.vocabulary import display_name

from ._labels import BESIDE_SIZE, height_of, width_of, write_beside
from ._style import BAND, BAND_INK, CURVES, PROOFS, SUPPLY, THRESHOLDS

LEAST_HEIGHT_IN = 1.1
_GAP_S = 1.5
"""Longest gap in a curve, s: steady pressures are written twice a second, so a longer gap means lost data."""


@dataclass(frozen=True)
class PanelCurve:
    """The curve of one channel, in kPa gauge or the unit of its panel; NaN: no value."""

    title: str
    colour: str
    times_s: list[float]
    kpa: list[float]

    @property
    def last(self) -> float:
        """The last valid value."""
        return next(value for value in reversed(self.kpa) if not math.isnan(value))


class Compared(NamedTuple):
    """A threshold of a condition on a quantity, in the unit of its panel."""

    channel: str
    proves: str
    sign: str
    at: float


_MOST_COMPARED, _MOST_AT = 8, 1e6
_COMPARED = ("<", ">", "≤", "≥")

_SIGNS = {"secure": "≤≥", "lost": "><"}
"""Comparison signs for a vacuum, and for a pressure above ambient."""


@dataclass
class Panel:
    """Curves that share an axis.

    ``bands`` are confirming thresholds and ``lines`` the others: gauge kPa, and the actuators that have them.
    ``compared``: thresholds of another quantity, used instead.
    """

    title: str
    below: bool
    curves: list[PanelCurve] = field(default_factory=list)
    bands: dict[float, list[str]] = field(default_factory=dict)
    lines: dict[tuple[str, float], list[str]] = field(default_factory=dict)
    compared: list[Compared] = field(default_factory=list)

    @property
    def height_in(self) -> float:
        """Height needed for the text at the right, inches."""
        lines = sum(text.count("\n") + 1 for _, text, _ in self.labels())
        return max(LEAST_HEIGHT_IN, lines * height_of(BESIDE_SIZE))

    def range_kpa(self) -> tuple[float, float]:
        """Return the range of the axis: all measured values, zero, and some of the accepted range."""
        values = [value for curve in self.curves for value in curve.kpa if not math.isnan(value)]
        values += [limit - 15 if self.below else limit * 1.12 for limit in self.bands]
        values += [limit - 5 if self.below else limit for _, limit in self.lines]
        values += [each.at for each in self.compared]
        low, high = min(0.0, *values), max(0.0, *values)
        room = max(0.07 * (high - low), 1.0)
        return low - room, high + room

    def labels(self) -> list[tuple[float, str, str]]:
        """Return (kPa, text, colour) at the right end."""
        low, high = self.range_kpa()
        found = [(curve.last, curve.title, curve.colour) for curve in self.curves]
        for limit, whose in self.bands.items():
            sign, edge = ("≤", low) if self.below else ("≥", high)
            text = f"{_named(whose, self.bands)}confirmed {sign} {limit:g}".replace("-", "−")
            found.append(((limit + edge) / 2, text, BAND_INK))
        for (word, limit), whose in self.lines.items():
            sign = _SIGNS[word][0 if self.below else 1]
            alike = [each for each in self.lines if each[0] == word]
            text = f"{_named(whose, alike)}{word} {sign} {limit:g}".replace("-", "−")
            found.append((limit, text, THRESHOLDS[word][0]))
        for each in self.compared:
            name = f"{display_name(each.channel)}\n" if len(self.curves) > 1 else ""
            text = f"{name}{each.proves} {each.sign} {each.at:g}".replace("-", "−")
            found.append((each.at, text, PROOFS[each.proves][0]))
        return found


_MOST_NAMED = 3


def _named(whose: list[str], alike: Collection[object]) -> str:
    """Return the owners of a threshold if several thresholds differ; empty if it has many owners."""
    return f"{' and '.join(whose)}\n" if len(alike) > 1 and len(whose) < _MOST_NAMED else ""


def panels_of(
    pressures: PressuresLog | None,
    info: RunInfo,
    actuators: tuple[str, ...],
) -> list[Panel]:
    """Return panels: one for vacuums, one for pressures above ambient, one for each other unit.

    A channel without any value is omitted.
    """
    others: dict[str, Panel] = {}
    below, above = Panel("vacuum\n[gauge kPa]", below=True), Panel("pressure\n[gauge kPa]", below=False)
    colours = {name: CURVES[index % len(CURVES)] for index, name in enumerate(actuators)}
    for channel in pressures.channels if pressures else ():
        assert pressures is not None
        curve = pressures.curve(channel)
        values = [value for value in curve if value is not None]
        if not values:
            continue
        if unit := pressures.units.get(channel):
            panel = others.setdefault(unit, Panel(f"measured\n[{unit}]", below=False))
            colour = CURVES[(len(actuators) + len(panel.curves)) % len(CURVES)]
            panel.curves.append(PanelCurve(display_name(channel), colour, *_broken(pressures.times_s, curve)))
            panel.compared = (panel.compared + _compared(channel, info, actuators))[:_MOST_COMPARED]
            continue
        owner = _owner(channel, info, actuators)
        panel = below if _is_below_ambient(owner, values, info) else above
        title, colour = (display_name(owner), colours[owner]) if owner else (display_name(channel), SUPPLY)
        panel.curves.append(PanelCurve(title, colour, *_broken(pressures.times_s, curve)))
        if owner:
            sign = -1 if panel.below else 1
            if limit := _limit(info, owner, "confirmed"):
                panel.bands.setdefault(sign * limit, []).append(title)
            for word in THRESHOLDS:
                if limit := _limit(info, owner, word):
                    panel.lines.setdefault((word, sign * limit), []).append(title)
    return [panel for panel in (below, above, *others.values()) if panel.curves]


def _compared(channel: str, info: RunInfo, actuators: Sequence[str]) -> list[Compared]:
    """Return the thresholds of all conditions on a channel that the run gives, without duplicates."""
    said = [info.limits.get(name, {}).get("measured") for name in actuators]
    listed = [each for some in said if isinstance(some, list) for each in some if isinstance(each, dict)]
    found = [
        Compared(channel, each["proves"], each["sign"], float(at))
        for each in listed
        if each.get("channel") == channel
        and each.get("proves") in (*PROOFS,)
        and each.get("sign") in _COMPARED
        if isinstance(at := each.get("at"), int | float) and abs(at) <= _MOST_AT
    ]
    return list(dict.fromkeys(found))


def _limit(info: RunInfo, actuator: str, word: str) -> float | None:
    """Return a threshold of an actuator, positive kPa; None if the run does not give it."""
    limit = info.limits.get(actuator, {}).get(f"{word}_kpa")
    usable = isinstance(limit, int | float) and math.isfinite(limit) and 0 < limit < 1e4
    return float(limit) if usable and limit is not None else None


def _owner(channel: str, info: RunInfo, actuators: tuple[str, ...]) -> str | None:
    """Return the actuator that a channel proves; without run.json, one whose name contains the channel's."""
    listed = [name for name in actuators if info.limits.get(name, {}).get("channel") == channel]
    named = [name for name in actuators if channel == name or channel in name.split("_")]
    return next(iter(listed + named), None)


def _is_below_ambient(owner: str | None, values: list[float], info: RunInfo) -> bool:
    if owner is not None:
        return recorded_kind(owner, info.actuators).below_ambient
    return max(values) < 20


def _broken(times_s: tuple[float, ...], values: tuple[float | None, ...]) -> tuple[list[float], list[float]]:
    """Return the curve with a gap wherever no valid value was received."""
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
    """Return the width of the text at the right, inches."""
    texts = [line for panel in panels for _, text, _ in panel.labels() for line in text.split("\n")]
    return max((width_of(text, BESIDE_SIZE) for text in texts), default=0.0)


def draw_panel(axes: Axes, panel: Panel) -> None:
    """Draw curves, accepted ranges, and their text at the right."""
    low, high = panel.range_kpa()
    axes.set_ylim(low, high)
    axes.set_ylabel(panel.title, fontsize=9.5)
    axes.yaxis.set_major_locator(MaxNLocator(nbins=3, steps=[1, 2, 2.5, 5, 10]))
    axes.spines[["top", "right"]].set_visible(False)
    axes.axhline(0.0, color="#e3e6eb", linewidth=0.8, zorder=0)
    for limit in panel.bands:
        axes.axhspan(*((low, limit) if panel.below else (limit, high)), color=BAND, linewidth=0, zorder=0)
    for word, limit in panel.lines:
        colour, dashes = THRESHOLDS[word]
        axes.axhline(limit, color=colour, linestyle=dashes, linewidth=0.9, zorder=1, label=word)
    for line in panel.compared:
        colour, dashes = PROOFS[line.proves]
        axes.axhline(line.at, color=colour, linestyle=dashes, linewidth=0.9, zorder=1, label=line.proves)
    for curve in panel.curves:
        axes.plot(curve.times_s, curve.kpa, color=curve.colour, linewidth=1.3, label=curve.title)
    write_beside(axes, panel.labels(), panel.height_in)
