"""A solenoid valve: it switches a dead time after its coil does."""

from __future__ import annotations


class Valve:
    """A mono-stable valve with a dead time; a pulse shorter than that does not switch it.

    Args:
        delay_us: from the coil to the air. Vacuum valves 20 to 45 ms, cylinder valves 15 to 60 ms.
    """

    def __init__(self, delay_us: int) -> None:
        self.delay_us = delay_us
        self.is_open = False
        self._switches_at: int | None = None

    @property
    def settled(self) -> bool:
        """No switching is under way."""
        return self._switches_at is None

    def command(self, opens: bool, at: int) -> None:
        """Switch the coil at ``at`` (µs)."""
        if opens == self.is_open:
            self._switches_at = None
        elif self._switches_at is None:
            self._switches_at = at + self.delay_us

    def advance(self, now: int) -> bool:
        """Whether it is open at ``now`` (µs)."""
        if self._switches_at is not None and now >= self._switches_at:
            self.is_open, self._switches_at = not self.is_open, None
        return self.is_open
