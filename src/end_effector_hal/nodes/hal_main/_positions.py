"""The latest positions, which count for as long as the node Position repeats them."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum

from end_effector_hal.nodes.interface import GONE_AFTER_S


class Positions:
    """The latest position of each part; one that is not repeated is UNKNOWN. Times in µs, monotonic.

    Args:
        places: the enumeration of each part; 0 is UNKNOWN in all of them.
    """

    def __init__(self, places: Mapping[str, type[IntEnum]]) -> None:
        self._places = places
        self._latest: dict[str, tuple[int, int]] = {}

    def store(self, name: str, position: int, at_us: int) -> None:
        """A position was received at ``at_us``."""
        self._latest[name] = (position, at_us)

    def place(self, name: str, now_us: int) -> IntEnum:
        """Where a part stands; UNKNOWN when that was not received for a second."""
        position, at_us = self._latest.get(name, (0, 0))
        places = {place.value: place for place in self._places[name]}
        return places.get(position if now_us - at_us <= GONE_AFTER_S * 1e6 else 0, places[0])

    def names(self, now_us: int) -> dict[str, str]:
        """The names of all positions that were ever received."""
        return {name: self.place(name, now_us).name for name in self._latest}
