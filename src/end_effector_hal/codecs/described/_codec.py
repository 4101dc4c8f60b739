"""The common parts of declared codecs, for all formats."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, NamedTuple

from end_effector_hal.codecs._codec import Decoder
from end_effector_hal.description import Channel
from end_effector_hal.signals import Frame, Kind


class SerialLine(NamedTuple):
    """Settings of a serial line; ``period_us`` None: the period follows from the format."""

    baudrate: int
    parity: str
    period_us: int | None
    stopbits: int = 1

    @property
    def byte_bits(self) -> int:
        """Bits of a byte on the line: start, 8, parity, stop."""
        return 9 + (self.parity != "N") + self.stopbits


class DescribedCodec(ABC):
    """The base of declared codecs: everything except the format.

    Args:
        channels: the channels of the link.
        line: settings of the link.
        least_period_us: shortest time to transmit a frame, µs.
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
        """Return a new decoder for one stream."""

    @abstractmethod
    def encode(self, frame: Frame) -> bytes:
        """Return the bytes of a frame; each value is rounded to the nearest one of its raw type."""


def by_place(channels: Mapping[str, Channel], source: str) -> dict[Any, dict[str, Channel]]:
    """Return the channels of one source, by their places on the wire."""
    found: dict[Any, dict[str, Channel]] = {}
    for name, each in channels.items():
        found.setdefault(getattr(each, source), {})[name] = each
    return found
