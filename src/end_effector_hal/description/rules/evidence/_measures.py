"""The unit and the number of decimals with which the values of each channel are displayed."""

from __future__ import annotations

from collections.abc import Iterator

from end_effector_hal.description.model import Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.signals import Measure

from ._channels import used_channels
from ._span_search import unit_of

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
    for _, part in description.ordered:
        for leaf in part.evidence.leaves if part.evidence else ():
            yield from ((leaf.channel, value) for _, value in leaf.thresholds)
        if part.evidence is None:
            limits = kind_of(part).limits(part, description.supply)
            yield from ((part.channel, value) for key, value in limits.items() if key.endswith("_kpa"))


def _decimals(value: float) -> int:
    return min(MOST, len(f"{value:.6f}".rstrip("0").partition(".")[2]))
