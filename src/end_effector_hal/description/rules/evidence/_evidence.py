"""Compares evidence with the possible values of channels: what never holds, and what holds at once."""

from __future__ import annotations

from collections.abc import Iterator

from end_effector_hal.description._fault import Fault
from end_effector_hal.description._numbers import number
from end_effector_hal.description.model._description import Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.kinds.stanza import EvidenceConditions
from end_effector_hal.signals import Kind

from ._channels import CodecChannels
from ._span_search import BIT, Spans, SpanSearch, Wanted, range_kpa, unit_of, widest

CODE = "EE-227"


def impossible_evidence(description: Description, codec: CodecChannels) -> Iterator[Fault]:
    """Yield faults of the actuators whose evidence no value of their channels can prove."""
    for name, part in description.ordered:
        if part.evidence is not None:
            yield from _impossible_conditions(description, name, part.evidence)
        else:
            yield from _impossible_limits(description, codec, name)


def overlapping_evidence(description: Description) -> Iterator[str]:
    """Yield a sentence for each actuator whose channels can confirm it and prove it gone at once.

    If two sensors contradict each other, a sensor is faulty. If the same sensors can show both, the description is
    faulty.
    """
    for name, part in description.ordered:
        asked = part.evidence
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
    part = description.actuators[name]
    kind = kind_of(part)
    span = range_kpa(description, part.channel)
    if kind.conditions(part) or span is None or codec.channels.get(part.channel) is not Kind.PRESSURE:
        return
    limits = kind.limits(part, description.supply)
    sign = -1 if kind.below_ambient else 1
    low, high = sorted(sign * each for each in span)
    for key in ("confirmed_kpa", "gone_kpa"):
        limit = limits.get(key)
        if limit is None or (limit <= high if key == "confirmed_kpa" else limit > low):
            continue
        which = key.removesuffix("_kpa")
        path = (key,) if key in part.model_fields_set else ("channel",)
        what = f"{name!r} can never be {which}: that takes {number(sign * limit)} kPa"
        place = description.place("actuators", name, *path)
        yield Fault.at(place, CODE, what, found="", expected=_by_range(description, part.channel))
