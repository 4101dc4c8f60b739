"""What declared codecs have in common, whatever their format."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, NamedTuple

from end_effector_hal.codecs._codec import Decoder
from end_effector_hal.description import Channel
from end_effector_hal.signals import Frame, Kind


class SerialLine(NamedTuple):
    """How the bytes come; ``period_us`` None: as fast as the format does."""

    baudrate: int
    parity: str
    period_us: int | None
    stopbits: int = 1

    @property
    def byte_bits(self) -> int:
        """Of a byte on the line: start, 8, parity, stop."""
        return 9 + (self.parity != "N") + self.stopbits


class DescribedCodec(ABC):
    """Everything but the format.

    Args:
        channels: those that come over the link.
        line: of the link.
        least_period_us: µs that a frame takes on it, at least.
    """

    name = "the declared frame"
    PERIOD_US = 20_000

    def __init__(self, channels: Mapping[str, Channel], line: SerialLine, least_period_us: int) -> None:
        self.channels: Mapping[str, Kind] = {name: each.kind for name, each in channels.items()}
        steps = [channel.step_pa for channel in channels.values() if channel.kind is Kind.PRESSURE]
        self.resolution_pa = max(steps, default=1.0)
        self.baudrate, self.parity = line.baudrate, line.parity
        self.least_period_us = least_period_us
        self.period_us = line.period_us or max(self.PERIOD_US, least_period_us)

    @abstractmethod
    def decoder(self) -> Decoder:
        """A new one, for one stream."""

    @abstractmethod
    def encode(self, frame: Frame) -> bytes:
        """The bytes of a frame, each value as near as its raw type can hold."""


def by_place(channels: Mapping[str, Channel], source: str) -> dict[Any, dict[str, Channel]]:
    """The channels of one source, by their places on the wire."""
    found: dict[Any, dict[str, Channel]] = {}
    for name, each in channels.items():
        found.setdefault(getattr(each, source), {})[name] = each
    return found
