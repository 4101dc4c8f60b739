"""What every driven device of the bench has: a valve, and a way to fail."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping

from ._grid import Model
from ._valve import Valve


class Device(Model):
    """A model behind a valve that a line switches."""

    def __init__(self, valve: Valve, start: int = 0) -> None:
        super().__init__(start)
        self.valve = valve

    def command(self, active: bool, at: int) -> None:
        """Switch the valve's coil at ``at`` (µs)."""
        self.valve.command(active, at)

    def lose(self, at: int) -> None:
        """Lose what is held, with the valve still energised: here, the air supply of this device fails."""
        self.valve.command(False, at)

    def leak(self, litres_min: float, grows_l_min_s: float = 0.0) -> None:
        """Leak this much from now on, and more with each second of suction; only a vacuum does."""
        if litres_min or grows_l_min_s:
            raise ValueError(f"{type(self).__name__} has no leak")

    @property
    def draw_kpa(self) -> float:
        """How far it pulls down the supply at this moment."""
        return 0.0

    @abstractmethod
    def settle(self, active: bool) -> None:
        """Take the state that it has after being active, or inactive, for a long time."""

    @property
    @abstractmethod
    def pressure_kpa(self) -> float | None:
        """Gauge pressure at its sensor (vacuum negative); ``None``: it has no pressure sensor."""

    @property
    @abstractmethod
    def bits(self) -> Mapping[str, bool]:
        """Its position switches, by what they mean."""
