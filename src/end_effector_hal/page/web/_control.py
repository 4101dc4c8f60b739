"""The control lease: one open page at a time may command, visibly to all, while it renews the lease; no I/O."""

from __future__ import annotations

from typing import Any

from end_effector_hal.control import Answer

LEASE_US = 10_000_000


class ControlLease:
    """A lease held by one page; times in µs. It does not lock out ROS clients or the prompt."""

    def __init__(self) -> None:
        self._holder = self._name = ""
        self._until = 0

    def holder(self, at: int) -> str:
        """Return the page that has the control; empty if none has."""
        return self._holder if at < self._until else ""

    def take(self, page: str, name: str, at: int) -> Answer:
        """Give the control to a page, or renew its lease."""
        if (holder := self.holder(at)) and holder != page:
            left_s = (self._until - at) / 1e6
            return Answer(
                False,
                f"{self._name} has the control until it releases it or is silent for {left_s:.0f} s.",
            )
        self._holder, self._name, self._until = page, name, at + LEASE_US
        return Answer(True)

    def renew(self, page: str, at: int) -> bool:
        """Renew the control; return whether the page still had it."""
        if self.holder(at) != page:
            return False
        self._until = at + LEASE_US
        return True

    def release(self, page: str, at: int) -> None:
        """Release the control; this ends nothing else."""
        if self.holder(at) == page:
            self._until = at

    def shown(self, at: int) -> dict[str, Any]:
        """Return the state of the control, as shown on every page."""
        holder = self.holder(at)
        return {
            "holder": holder,
            "name": self._name if holder else "",
            "left_s": max(0, self._until - at) / 1e6,
        }
