"""One place on the wire, and the channels that are read from it; one number may contain several channels."""

from __future__ import annotations

from collections.abc import Mapping
from math import ceil, floor

from end_effector_hal.description import Channel
from end_effector_hal.signals import Value

Limits = tuple[int, int] | None


class Field:
    """Converts a raw value to the values of its channels, and back.

    Args:
        channels: the channels by name: one, or several bits with different ``on`` values.
        limits: the lowest and the highest raw value; None: floating point.
    """

    def __init__(self, channels: Mapping[str, Channel], limits: Limits = None) -> None:
        self.channels = dict(channels)
        self._limits = limits

    def values(self, raw: float | None) -> dict[str, Value]:
        """Return the values of a raw value; None: there is no raw value."""
        return {name: None if raw is None else each.value(raw) for name, each in self.channels.items()}

    def implausible(self, raw: float | None) -> bool:
        """Return whether no sensor can send this raw value; False if it is a declared invalid value."""
        return raw is not None and any(
            raw == raw and raw not in each.invalid and each.value(raw) is None
            for each in self.channels.values()
        )

    def raw(self, values: Mapping[str, Value]) -> float | None:
        """Return the raw value that a device sends for these values; None: the format cannot encode a missing value.

        A value beyond its range is sent as the end of the range, as sensors do; a channel that is missing in
        ``values`` is sent as 0.
        """
        wanted = {name: values[name] for name in self.channels if name in values}
        first = next(iter(self.channels.values()))
        if None in wanted.values() or not wanted:
            raw = self._invalid(first)
            return raw if raw is not None or wanted else self._nearest(first, 0)
        if len(self.channels) == 1:
            (value,) = wanted.values()
            return self._nearest(first, value or 0)
        candidates = [0, 1, *(raw for each in self.channels.values() for raw in each.on or ())]
        candidates += [value for value in wanted.values() if type(value) is int]  # a code
        candidates += range(len(candidates))

        def agree(raw: float) -> int:
            return sum(self.channels[name].value(raw) == value for name, value in wanted.items())

        return float(max(filter(self._fits, candidates), key=agree))

    def _fits(self, raw: float) -> bool:
        return self._limits is None or self._limits[0] <= raw <= self._limits[1]

    def _invalid(self, channel: Channel) -> float | None:
        """Return a raw value that means "no value": a declared one, or one out of range; None: there is none."""
        if channel.invalid:
            return float(channel.invalid[0])
        if channel.range is None:
            return None
        ends = ((each - channel.offset) / channel.scale for each in channel.range)
        beyond = [raw for end in ends for raw in (floor(end) - 1.0, ceil(end) + 1.0)]
        return next((raw for raw in beyond if self._fits(raw) and channel.value(raw) is None), None)

    def _nearest(self, channel: Channel, value: int | bool) -> float:
        """Return the raw value nearest to this value."""
        raw = channel.raw(value)
        if channel.unit is None:
            return raw
        if channel.range is not None:
            low, high = sorted((each - channel.offset) / channel.scale for each in channel.range)
            raw = min(max(raw, low), high)
        if self._limits is None:
            return raw
        if channel.range is not None and not low <= round(raw) <= high:
            raw = ceil(raw) if ceil(raw) <= high else floor(raw)
        raw = min(max(round(raw), self._limits[0]), self._limits[1])
        near = (each for step in range(len(channel.invalid) + 1) for each in (raw + step, raw - step))
        return float(next((each for each in near if each not in channel.invalid and self._fits(each)), raw))
