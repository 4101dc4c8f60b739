"""Samples of channels, one after the other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from end_effector_hal.signals import Kind, Value


class Samples:
    """What each channel shows; None: nothing that is fresh and valid.

    ``arrived``: whether a frame brought it; None: it did where there is a value.
    """

    carried: ClassVar[Mapping[str, Kind]] = {}

    def __init__(self, values: Mapping[str, Value], *, arrived: bool | None = None) -> None:
        self._values, self._arrived = values, arrived
        self.fresh = {name: value for name, value in values.items() if value is not None}

    def get(self, channel: str | None, at: int) -> int | bool | None:
        return None if channel is None else self.fresh.get(channel)

    @property
    def arrived(self) -> frozenset[str]:
        return frozenset(self.fresh if self._arrived is None else self._values if self._arrived else ())
