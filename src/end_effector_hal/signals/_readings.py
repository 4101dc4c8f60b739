"""What a detector sees of the channels."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from ._frame import Kind


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
