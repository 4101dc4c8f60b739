"""The measured values of an actuator: gauges on its card, with threshold marks, and curves over time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from end_effector_hal.description import Description, measures_of
from end_effector_hal.kinds import kind_of
from end_effector_hal.kinds.stanza import Actuator
from end_effector_hal.signals import GAUGE_PRESSURE, Kind, Measure
from end_effector_hal.vocabulary import display_name

_LIMITS = ("gone", "lost_at_once", "lost", "confirmed", "secure")
_CONDITIONS = ("gone", "lost", "empty", "confirmed")
_MEASURED = (Kind.PRESSURE, Kind.QUANTITY)
Marks = tuple[tuple[str, float], ...]


class Curve(NamedTuple):
    """One measured channel.

    Attributes:
        name: unique among the curves of a tool: the actuator's name for its own pressure, else the channel's name.
        channel: the channel that has the values.
        label: name shown to users.
        unit: unit, with the reference of a pressure.
        below: whether a pressure below ambient is shown as a positive number.
        decimals: number of decimals shown.
        low: lower end of the scale.
        most: upper end of the scale.
        marks: by part, its thresholds, each with its word.
        own: whether this is the pressure of the actuator itself.
    """

    name: str
    channel: str
    label: str
    unit: str
    below: bool = False
    decimals: int = 1
    low: float = 0.0
    most: float = 1.0
    marks: Mapping[str, Marks] = MappingProxyType({})
    own: bool = False

    def shown(self, value: int) -> float:
        """Convert a value of the channel to the unit."""
        return (-value if self.below else value) / 1000

    def drawn(self) -> dict[str, Any]:
        """Return the constant properties, which are sent to a page once."""
        marks = {
            part: [{"word": word.replace("_", " "), "at": at} for word, at in each]
            for part, each in self.marks.items()
        }
        return {**self._asdict(), "marks": marks}

    def joined(self, other: Curve) -> Curve:
        """Return this curve with the marks of the same channel for another part, on a scale that has both."""
        marks = {**self.marks, **other.marks}
        return self._replace(marks=marks, low=min(self.low, other.low), most=max(self.most, other.most))


def curves_of(description: Description, carried: Mapping[str, Kind]) -> dict[str, tuple[Curve, ...]]:
    """Return curves by actuator, in grip order: its own pressure, then other channels of its conditions."""
    measures = measures_of(description)
    found: dict[str, dict[str, Curve]] = {name: {} for name in description.sequence}
    for part, tool in zip(description.part_names, description.per_part, strict=True):
        for name, actuator in tool.ordered:
            for curve in _curves(tool, name, actuator, carried, measures):
                own = curve._replace(marks={part: curve.marks[""]})
                before = found[name].get(curve.name)
                found[name][curve.name] = before.joined(own) if before else own
    return {name: tuple(curves.values()) for name, curves in found.items()}


def _curves(
    description: Description,
    name: str,
    actuator: Actuator,
    carried: Mapping[str, Kind],
    measures: Mapping[str, Measure],
) -> Iterator[Curve]:
    kind = kind_of(actuator)
    if carried.get(actuator.channel) is Kind.PRESSURE:
        marks = (
            _limits(description, actuator)
            if actuator.evidence is None
            else _thresholds(actuator, actuator.channel)
        )
        if kind.below_ambient and actuator.evidence is not None:
            marks = [(word, -at) for word, at in marks]
        most = max([at for _, at in marks], default=1.0)
        yield Curve(
            name,
            actuator.channel,
            display_name(name),
            "kPa below ambient" if kind.below_ambient else "kPa",
            kind.below_ambient,
            most=100.0 if kind.below_ambient and most <= 100 else round(most * 1.4, -1),
            marks={"": tuple(marks)},
            own=True,
        )
    for channel in actuator.evidence.channels if actuator.evidence else ():
        if channel != actuator.channel and carried.get(channel) in _MEASURED:
            yield _quantity(
                description, channel, _thresholds(actuator, channel), measures.get(channel, GAUGE_PRESSURE)
            )


def _limits(description: Description, actuator: Actuator) -> list[tuple[str, float]]:
    limits = kind_of(actuator).limits(actuator, description.supply)
    values = ((word, limits.get(f"{word}_kpa", getattr(actuator, f"{word}_kpa", None))) for word in _LIMITS)
    return [(word, float(value)) for word, value in values if value is not None]


def _thresholds(actuator: Actuator, channel: str) -> list[tuple[str, float]]:
    given = dict(actuator.evidence.named) if actuator.evidence else {}
    return [
        (word, float(value))
        for word in _CONDITIONS
        if word in given
        for leaf in given[word].leaves
        if leaf.channel == channel
        for _, value in leaf.thresholds
    ]


def _quantity(
    description: Description, channel: str, marks: list[tuple[str, float]], measure: Measure
) -> Curve:
    declared = description.channels.get(channel)
    values = [at for _, at in marks]
    low, most = min([0.0, *values]) * 1.4, max([0.0, *values]) * 1.4
    if declared is not None and declared.range is not None:
        low, most = declared.range
    return Curve(
        channel,
        channel,
        display_name(channel),
        measure.unit,
        decimals=measure.decimals,
        low=float(low),
        most=float(most) if most > low else low + 1.0,
        marks={"": tuple(dict.fromkeys(marks))},
    )
