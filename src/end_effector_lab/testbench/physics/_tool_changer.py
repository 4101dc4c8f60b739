"""A tool changer: active unlocks, inactive locks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from ._device import CHANGER, Device
from ._parts import STEP_S, Valve

_SWITCH = 0.02
_TRAVEL = STEP_S / 0.15  # from one end to the other


class ToolChanger(Device):
    """A piston between two switches; in between, both are off.

    Args:
        valve: unlocks when open.
    """

    traits: ClassVar = frozenset({CHANGER})

    def __init__(self, valve: Valve | None = None, *, start: int = 0) -> None:
        super().__init__(valve or Valve(30_000), start)
        self.position = 0.0  # 0 locked, 1 unlocked

    @property
    def pressure_kpa(self) -> None:
        return None

    @property
    def bits(self) -> Mapping[str, bool]:
        return {"locked": self.position <= _SWITCH, "unlocked": self.position >= 1 - _SWITCH}

    @property
    def settled(self) -> bool:
        return self.valve.settled and self.position == (1.0 if self.valve.is_open else 0.0)

    def settle(self, active: bool) -> None:
        self.valve.is_open = active
        self.position = 1.0 if active else 0.0

    def step(self) -> None:
        if self.valve.advance(self.now):
            self.position = min(self.position + _TRAVEL, 1.0)
        else:
            self.position = max(self.position - _TRAVEL, 0.0)
