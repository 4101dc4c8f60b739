"""Values for sensors that only evidence conditions use: they make `confirmed` or `gone` true to match the device."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from end_effector_hal.description import BIT, Description, Spans, SpanSearch, Wanted, range_kpa, widest
from end_effector_hal.errors import UsageError
from end_effector_hal.kinds import kind_of
from end_effector_hal.kinds.stanza import EvidenceConditions, named

from .physics import Device

AWAY_KPA = 5.0
"""Distance of a shown value from a threshold, kPa, where the span is wide enough."""


@dataclass(frozen=True)
class ShownByConditions:
    """The values of the free channels of one actuator, as one span per channel for every state of the device.

    Attributes:
        bits: channels that are bits.
        confirmed, gone, between, empty: spans of the channels in these states; None if there are no such values.
    """

    bits: frozenset[str]
    confirmed: Spans
    gone: Spans
    between: Spans | None
    empty: Spans | None

    def at(self, device: Device) -> Iterator[tuple[str, bool | float]]:
        """Yield channels with their bit or gauge kPa; a pressure follows the device's as far as its span allows."""
        for channel, (low, high) in self._spans(device).items():
            if channel in self.bits:
                yield channel, low == 1.0
            else:
                away = min(AWAY_KPA, (high - low) / 2)
                yield channel, min(max(device.pressure_kpa or 0.0, low + away), high - away)

    def _spans(self, device: Device) -> Spans:
        """Return the spans for the state of a device. If no values exist for a moving device, the spans of the state
        that it leaves stay until it arrives.
        """
        if device.grips:
            return self.confirmed
        if device.is_released:
            return self.gone
        if device.is_empty and self.empty is not None:
            return self.empty
        if self.between is not None:
            return self.between
        return self.gone if device.valve.is_open else self.confirmed


def shown_by_conditions(description: Description) -> dict[str, ShownByConditions]:
    """Return the values by actuator, for all whose `evidence` uses channels that nothing else sets.

    Channels that the actuator's kind sets, and those of other parts, are left out.

    Raises:
        UsageError: no values of its channels make a condition true without making another one true as well.
    """
    taken = {description.supply.channel, *_elsewhere(description)}
    found: dict[str, ShownByConditions] = {}
    for name, actuator in description.ordered:
        if actuator.evidence is None:
            continue
        free = {
            leaf.channel: BIT
            if leaf.bit
            else range_kpa(description, leaf.channel) or widest(description, leaf.channel)
            for leaf in actuator.evidence.leaves
            if leaf.channel not in taken
        }
        taken |= free.keys()
        if free:
            found[name] = _solved(description, name, actuator.evidence, free)
    return found


def _elsewhere(description: Description) -> Iterator[str]:
    """Yield the channels that the bench sets by their meaning."""
    for _, actuator in description.ordered:
        for key in kind_of(actuator).channels:
            # what evidence replaces is not asked for by default
            if (channel := named(getattr(actuator, key.key))) and (
                actuator.evidence is None or key.key in actuator.model_fields_set
            ):
                yield channel
    if changer := description.tool_changer:
        yield from (changer.locked_bit, changer.unlocked_bit, changer.stand_bit, changer.present_bit)
    if description.e_stop:
        yield description.e_stop.channel


def _solved(description: Description, name: str, asked: EvidenceConditions, free: Spans) -> ShownByConditions:
    def shown(*which: str) -> Spans | None:
        return SpanSearch().solved(_wanted(asked, which), free)

    confirmed, gone = shown("confirmed"), shown("gone")
    if confirmed is None or gone is None:
        which = "gone" if gone is None else "confirmed"
        raise UsageError(
            f"{name!r} cannot be simulated: no value of its channels makes {which!r} true alone.",
            where=description.where("actuators", name, "evidence", which),
            todo="Can its conditions hold one at a time?",
        )
    bits = frozenset(leaf.channel for leaf in asked.leaves if leaf.bit)
    return ShownByConditions(bits, confirmed, gone, shown(), shown("empty") if asked.empty else None)


def _wanted(asked: EvidenceConditions, which: tuple[str, ...]) -> list[Wanted]:
    """Return the conditions that must hold, and all others as conditions that must not."""
    wanted = [
        (condition, key in which)
        for key, condition in asked.named
        if key != "lost" or "confirmed" in which  # what is not confirmed may be lost
    ]
    first, second = asked.confirmed.asked, asked.gone.asked
    if asked.fault is None and first is not None and second is not None:  # both are a contradiction
        wanted += [(second, False)] if "confirmed" in which else [(first, False)] if "gone" in which else []
    return wanted
