"""Selects the faults that a tool can have, and the places where they can occur."""

from __future__ import annotations

from collections.abc import Iterator

from end_effector_hal.description import Description
from end_effector_hal.faults import FaultNumber, FaultOffer

from ._scenario import FAULTS, Fault, Number, links_that_ask, traits_of


def possible_faults(description: Description) -> Iterator[str]:
    """Yield the faults that a tool can have, with their places and without their numbers."""
    for offer in offered_faults(description):
        if offer.anywhere:
            yield offer.name
        else:
            yield from (f"{offer.name}:{place}" for place in offer.places)


def offered_faults(description: Description) -> Iterator[FaultOffer]:
    """Yield the faults that a tool can have, with the data that a user interface needs to offer them: meaning, usage,
    places and number.
    """
    traits = traits_of(description)
    alarms = tuple(name for name, channel in description.channels.items() if channel.alarm)
    asking = links_that_ask(description)
    named = tuple(description.named_links)
    for fault in FAULTS:
        if fault.on:
            places = tuple(name for name, each in traits.items() if not each.isdisjoint(fault.on))
            if places:
                yield _offer(fault, places, anywhere=False)
        elif fault.channel:
            if alarms:
                yield _offer(fault, alarms, anywhere=False)
        elif fault.link == "polled":
            if asking:
                yield _offer(fault, tuple(name for name in named if name in asking))
        elif fault.link:
            if description.links or fault.link == "also":
                yield _offer(fault, named)
        else:
            yield _offer(fault)


def _offer(fault: Fault, places: tuple[str, ...] = (), *, anywhere: bool = True) -> FaultOffer:
    number = _number(fault.number) if fault.number else None
    return FaultOffer(fault.name, fault.meaning, fault.usage, places, anywhere, number)


def _number(number: Number) -> FaultNumber:
    return FaultNumber(number.name, number.low, number.high, number.default, number.whole)
