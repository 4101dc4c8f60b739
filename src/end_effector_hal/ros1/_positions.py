"""What HALMain knows of positions: for as long as the node Position goes on telling it."""

from __future__ import annotations

from typing import Any

from ._node import constant_name
from ._table import GONE_AFTER_S


class Positions:
    """The newest message of each; one that is not repeated is UNKNOWN. Times in µs, monotonic."""

    def __init__(self) -> None:
        self._newest: dict[str, tuple[Any, int]] = {}

    def take(self, name: str, message: Any, at_us: int) -> None:
        """A message has come."""
        self._newest[name] = (message, at_us)

    def value(self, name: str, now_us: int) -> int:
        """Its integer; 0, UNKNOWN in every message of positions, when it is not told any more."""
        message, at_us = self._newest.get(name, (None, 0))
        fresh = message is not None and now_us - at_us <= GONE_AFTER_S * 1e6
        return int(message.position) if fresh else 0

    def names(self, now_us: int) -> dict[str, str]:
        """All of them, in words."""
        return {
            name: constant_name(message, self.value(name, now_us))
            for name, (message, _) in self._newest.items()
        }
