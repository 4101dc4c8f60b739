"""The readings of the channels as a detector receives them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from ._frame import Frame, Kind


class ChannelReadings(Protocol):
    """The newest reading of each channel, as long as it is fresh and valid."""

    @property
    def carried(self) -> Mapping[str, Kind]:
        """The channels of the codec with their types."""
        ...

    def get(self, channel: str | None, at: int) -> int | bool | None:
        """Return gauge Pa (vacuum negative) or a bit at ``at`` µs; None: no fresh, valid reading."""
        ...

    def arrived(self, channel: str) -> bool:
        """Return whether the newest frame has a valid value of the channel: only that is a sample."""
        ...


class PassingReadings:
    """Readings of one frame that is not stored; other channels come from the stored readings.

    Args:
        remembered: the newest readings before the frame.
        frame: a frame of the same source, soon after them.
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
