"""Compares evidence with the possible values of channels, by a bounded search over spans of values.

What never holds is a fault, what holds at once is a sentence. The spans also give the number of decimals with which
the values of a channel are displayed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import inf

from end_effector_hal.description._fault import Fault
from end_effector_hal.description._numbers import number
from end_effector_hal.description.model._channels import COUNTS, PASCAL
from end_effector_hal.description.model._description import Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.kinds.stanza import Condition, EvidenceConditions
from end_effector_hal.signals import Kind, Measure

from ._channels import CodecChannels, used_channels

MOST_STEPS = 20_000
GAUGE_KPA = -100.0, 2000.0
QUANTITY = -1e6, 1e6

Span = tuple[float, float]
"""A range in kPa, or in the unit of a quantity; of a bit (0, 0), (1, 1), or (0, 1): either."""
Spans = Mapping[str, Span]
"""Spans by channel."""
Wanted = tuple[Condition, bool]
"""A condition, and whether it shall hold."""
BIT: Span = (0.0, 1.0)


def range_kpa(description: Description, channel: str) -> Span | None:
    """Return the ``range`` of a channel in kPa or the unit of its quantity; None: it declares none."""
    declared = description.channels.get(channel)
    if declared is None or declared.unit is None or declared.range is None:
        return None
    low, high = (each * COUNTS[declared.unit] / 1000 for each in declared.range)
    return low, high


def widest(description: Description, channel: str) -> Span:
    """Return the widest span that a channel can have, whatever its ``range``."""
    return QUANTITY if _is_quantity(description, channel) else GAUGE_KPA


def unit_of(description: Description, channel: str) -> str:
    """Return the unit in which a channel is displayed: kPa, or that of its quantity."""
    declared = description.channels.get(channel)
    return str(declared.unit) if declared and _is_quantity(description, channel) else "kPa"


def _is_quantity(description: Description, channel: str) -> bool:
    declared = description.channels.get(channel)
    return declared is not None and declared.unit is not None and declared.unit not in PASCAL


class SpanSearch:
    """Searches for spans of the channels that satisfy conditions, in a bounded number of steps."""

    def __init__(self) -> None:
        self._left = MOST_STEPS

    @property
    def gave_up(self) -> bool:
        """Whether the search ended before it was complete."""
        return self._left < 0

    def solved(self, wanted: list[Wanted], spans: Spans) -> Spans | None:
        """Return spans in which each condition holds or fails as wanted; None: none were found."""
        return next(self._all_of(wanted, spans), None)

    def _all_of(self, wanted: list[Wanted], spans: Spans) -> Iterator[Spans]:
        if not wanted:
            yield spans
            return
        (condition, holds), *rest = wanted
        for narrowed in self._where(condition, holds, spans):
            yield from self._all_of(rest, narrowed)

    def _where(self, condition: Condition, holds: bool, spans: Spans) -> Iterator[Spans]:
        """Yield the spans in which a condition holds or fails; channels without a span are ignored."""
        self._left -= 1
        if self._left < 0:
            return
        if condition.not_ is not None:
            yield from self._where(condition.not_, not holds, spans)
        elif not condition.parts:
            yield from _narrowed(condition, holds, spans)
        elif (condition.all is not None) is holds:
            yield from self._all_of([(part, holds) for part in condition.parts], spans)
        else:
            for part in condition.parts:
                yield from self._where(part, holds, spans)


def _narrowed(leaf: Condition, holds: bool, spans: Spans) -> Iterator[Spans]:
    channel = leaf.on or leaf.channel or ""
    if channel not in spans:
        yield spans
        return
    for first, last in _allowed(leaf, holds):
        low, high = max(spans[channel][0], first), min(spans[channel][1], last)
        if low < high or (leaf.on is not None and low == high):
            yield {**spans, channel: (low, high)}


def _allowed(leaf: Condition, holds: bool) -> list[Span]:
    if leaf.on is not None:
        return [(1.0, 1.0) if holds else (0.0, 0.0)]
    first, last = leaf.span
    if holds:
        return [(first, last)]
    return [span for span in ((-inf, first), (last, inf)) if span[0] < span[1]]


LEAST, MOST = 1, 3
"""Limits for the number of decimals; a value is in thousandths."""


def measures_of(description: Description) -> dict[str, Measure]:
    """Return the display format of each declared or used channel, with the decimals of its thresholds."""
    decimals: dict[str, int] = {}
    for channel, threshold in _thresholds(description):
        decimals[channel] = max(decimals.get(channel, LEAST), _decimals(threshold))
    names = dict.fromkeys([*description.channels, *used_channels(description)])
    return {name: Measure(unit_of(description, name), decimals.get(name, LEAST)) for name in names}


def _thresholds(description: Description) -> Iterator[tuple[str, float]]:
    for _, actuator in description.ordered:
        for leaf in actuator.evidence.leaves if actuator.evidence else ():
            yield from ((leaf.channel, value) for _, value in leaf.thresholds)
        if actuator.evidence is None:
            limits = kind_of(actuator).limits(actuator, description.supply)
            yield from ((actuator.channel, value) for key, value in limits.items() if key.endswith("_kpa"))


def _decimals(value: float) -> int:
    return min(MOST, len(f"{value:.6f}".rstrip("0").partition(".")[2]))


CODE = "EE-227"


def impossible_evidence(description: Description, codec: CodecChannels) -> Iterator[Fault]:
    """Yield faults of the actuators whose evidence no value of their channels can prove."""
    for name, actuator in description.ordered:
        if actuator.evidence is not None:
            yield from _impossible_conditions(description, name, actuator.evidence)
        else:
            yield from _impossible_limits(description, codec, name)


def overlapping_evidence(description: Description) -> Iterator[str]:
    """Yield a sentence for each actuator whose channels can confirm it and prove it gone at once.

    If two sensors contradict each other, a sensor is faulty. If the same sensors can show both, the description is
    faulty.
    """
    for name, actuator in description.ordered:
        asked = actuator.evidence
        if asked is None or {*asked.confirmed.channels} != {*asked.gone.channels}:
            continue
        both = [(asked.confirmed, True), (asked.gone, True)]
        if (found := SpanSearch().solved(both, _spans(description, asked))) is not None:
            shown = " and ".join(_shown(description, channel, found) for channel in asked.gone.channels)
            yield (
                f"{name}: evidence: 'confirmed' and 'gone' hold at once where {shown}: it is unknown there "
                f"({description.where('actuators', name, 'evidence', 'gone')})"
            )


def _spans(description: Description, asked: EvidenceConditions, *, ranges: bool = True) -> Spans:
    return {
        leaf.channel: BIT
        if leaf.bit
        else (range_kpa(description, leaf.channel) if ranges else None) or widest(description, leaf.channel)
        for leaf in asked.leaves
    }


def _shown(description: Description, channel: str, spans: Spans) -> str:
    low, high = spans[channel]
    if (low, high) in ((0.0, 0.0), (1.0, 1.0)):
        return f"{channel} is {'on' if low else 'off'}"
    return f"{channel} has {number(low)} to {number(high)} {unit_of(description, channel)}"


def _is_impossible(wanted: list[Wanted], spans: Spans) -> bool:
    search = SpanSearch()
    return search.solved(wanted, spans) is None and not search.gave_up


def _impossible_conditions(description: Description, name: str, asked: EvidenceConditions) -> Iterator[Fault]:
    spans, anywhere = _spans(description, asked), _spans(description, asked, ranges=False)
    for key, condition in asked.named:
        place = description.place("actuators", name, "evidence", key)
        if _is_impossible([(condition, True)], spans):
            limited = not _is_impossible([(condition, True)], anywhere)
            which = [each for each in condition.channels if limited and range_kpa(description, each)]
            expected = _by_range(description, which[0]) if which else "a condition that can hold"
            yield Fault.at(place, CODE, f"{key!r} of {name!r} can never hold", found="", expected=expected)
        elif key in ("confirmed", "gone"):
            others = [(each, other) for each, other in asked.named if each not in (key, "lost")]
            for each, other in others:
                if _is_impossible([(condition, True), (other, False)], spans):
                    what = f"{key!r} of {name!r} never holds without {each!r}"
                    yield Fault.at(place, CODE, what, found="", expected=f"what {each!r} does not show")


def _by_range(description: Description, channel: str) -> str:
    low, high = range_kpa(description, channel) or widest(description, channel)
    unit = unit_of(description, channel)
    return f"something between {number(low)} and {number(high)} {unit}, the range of {channel}"


def _impossible_limits(description: Description, codec: CodecChannels, name: str) -> Iterator[Fault]:
    """Yield faults of thresholds out of the channel's range, for a kind that judges a pressure itself."""
    actuator = description.actuators[name]
    kind = kind_of(actuator)
    span = range_kpa(description, actuator.channel)
    if kind.conditions(actuator) or span is None or codec.channels.get(actuator.channel) is not Kind.PRESSURE:
        return
    limits = kind.limits(actuator, description.supply)
    sign = -1 if kind.below_ambient else 1
    low, high = sorted(sign * each for each in span)
    for key in ("confirmed_kpa", "gone_kpa"):
        limit = limits.get(key)
        if limit is None or (limit <= high if key == "confirmed_kpa" else limit > low):
            continue
        which = key.removesuffix("_kpa")
        path = (key,) if key in actuator.model_fields_set else ("channel",)
        what = f"{name!r} can never be {which}: that takes {number(sign * limit)} kPa"
        place = description.place("actuators", name, *path)
        yield Fault.at(place, CODE, what, found="", expected=_by_range(description, actuator.channel))
