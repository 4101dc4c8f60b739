"""A line, the device on it, and what is wrong with that device."""

from __future__ import annotations

from ._scenario import Effect
from .physics import Device


class Station:
    """Turns the level of a line into what the device's valve does, under an :class:`Effect`.

    Args:
        device: what the line drives.
        active: level at the start, which has stood long enough for the device to have settled.
        effect: what is wrong with it.
    """

    def __init__(self, device: Device, *, active: bool = False, effect: Effect | None = None) -> None:
        self.device = device
        self.active = active
        self.effect = effect or Effect()
        self.due: int | None = None  # µs, when what is held will be lost
        self._activations = 0
        self._works = active
        device.leak(self.effect.leak_l_min, self.effect.leak_grows_l_min_s)
        device.settle(active)
        self._expect_loss(device.now)

    def line(self, active: bool, at: int) -> None:
        """The line has this level from ``at`` (µs) on."""
        if active == self.active:
            return
        self.active = active
        if active:
            self._activations += 1
            self._works = self._activations > self.effect.dead_activations
        self._drive(at)

    def suffer(self, effect: Effect, at: int) -> None:
        """Have another fault from ``at`` (µs) on; an activation that had its effect keeps it."""
        self.effect, self._activations = effect, 0
        if self.active and not self._works:
            self._activations = 1
            self._works = effect.dead_activations < 1
        self.device.leak(effect.leak_l_min, effect.leak_grows_l_min_s)
        self._drive(at)

    def lose(self) -> None:
        """Lose what is held; it was ``due``."""
        if self.due is not None:
            self.device.lose(self.due)
            self.due = None

    def _drive(self, at: int) -> None:
        if self.active:
            self.device.command(self._works, at)
        elif not (self.effect.stuck and self._works):
            self.device.command(False, at)
            self._works = False
        self._expect_loss(at)

    def _expect_loss(self, at: int) -> None:
        after = self.effect.lost_after_us
        self.due = at + after if after is not None and self.active and self._works else None
