"""What a kind proves with: readings in, evidence out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple, Protocol

from end_effector_hal.signals import Kind
from end_effector_hal.vocabulary import Evidence


class ChannelKey(NamedTuple):
    """A key of a stanza that names a channel of the link.

    Attributes:
        key: in the stanza; its value is the name of a channel, or ``none``: there is no such sensor.
        carries: a pressure or a bit. A key of a bit ends in ``_bit``; what stands before it is what the bit means.
        confirms: whether this channel alone can prove the actuator to be active.
        bit_instead: a bit in the place of this pressure says "present", as the switch of a vacuum does.
    """

    key: str
    carries: Kind
    confirms: bool = False
    bit_instead: bool = False

    @property
    def meaning(self) -> str:
        """What a bit says, such as ``extended`` of ``extended_bit``."""
        return self.key.removesuffix("_bit")


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


class Detector(Protocol):
    """The evidence of one actuator; its ``MEMORY`` is that of `end_effector_hal.signals.memory_of`."""

    MEMORY: ClassVar[dict[str, Any]]

    def sample(self, readings: ChannelReadings, at: int) -> Evidence:
        """The evidence at ``at`` µs: after a frame, and also when time alone has made readings stale."""
        ...
