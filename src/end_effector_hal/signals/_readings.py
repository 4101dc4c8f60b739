"""What a detector sees of the channels."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from ._frame import Frame, Kind


class ChannelReadings(Protocol):
    """The newest reading of each channel, as long as it is fresh and valid."""

    @property
    def carried(self) -> Mapping[str, Kind]:
        """The channels of the codec."""
        ...

    def get(self, channel: str | None, at: int) -> int | bool | None:
        """Gauge Pa (vacuum negative) or a bit at ``at`` µs; None: not carried, never read, stale, or invalid."""
        ...

    def arrived(self, channel: str) -> bool:
        """Whether the newest frame brought a valid value: only that is a sample to count."""
        ...


class PassingReadings:
    """What a frame shows that nobody remembers, and what is remembered of the other channels.

    Args:
        remembered: the newest readings before it.
        frame: of the same source, soon after.
    """

    def __init__(self, remembered: ChannelReadings, frame: Frame) -> None:
        self._remembered, self._values = remembered, frame.values

    @property
    def carried(self) -> Mapping[str, Kind]:
        """See `ChannelReadings`."""
        return self._remembered.carried

    def get(self, channel: str | None, at: int) -> int | bool | None:
        """See `ChannelReadings`."""
        value = None if channel is None else self._values.get(channel)
        if value is not None:
            return value
        return self._remembered.get(channel, at)  # an invalid value refreshes nothing

    def arrived(self, channel: str) -> bool:
        """See `ChannelReadings`."""
        return self._values.get(channel) is not None
