"""Which of the open pages commands: one at a time, visible to all, for as long as it renews. Sans-IO."""

from __future__ import annotations

from typing import Any

from end_effector_hal.control import Answer

LEASE_US = 10_000_000


class ControlLease:
    """Held by one page; times in µs. It is about pages only: ROS clients and the prompt are not locked out."""

    def __init__(self) -> None:
        self._holder = self._name = ""
        self._until = 0

    def holder(self, at: int) -> str:
        """The page that commands; empty: none."""
        return self._holder if at < self._until else ""

    def take(self, page: str, name: str, at: int) -> Answer:
        """Take the control, or renew it."""
        if (holder := self.holder(at)) and holder != page:
            left_s = (self._until - at) / 1e6
            return Answer(
                False,
                f"{self._name} has the control: until it gives it back, or is not there for {left_s:.0f} s.",
            )
        self._holder, self._name, self._until = page, name, at + LEASE_US
        return Answer(True)

    def renew(self, page: str, at: int) -> bool:
        """Whether it still had it."""
        if self.holder(at) != page:
            return False
        self._until = at + LEASE_US
        return True

    def release(self, page: str, at: int) -> None:
        """Release it; nothing else ends with it."""
        if self.holder(at) == page:
            self._until = at

    def shown(self, at: int) -> dict[str, Any]:
        """For every page."""
        holder = self.holder(at)
        return {
            "holder": holder,
            "name": self._name if holder else "",
            "left_s": max(0, self._until - at) / 1e6,
        }
