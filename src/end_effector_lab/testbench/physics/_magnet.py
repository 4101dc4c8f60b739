"""A magnet that holds while it is driven, and shortly afterwards."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

from ._device import ACTUATOR, PARTS, STICKS, Device
from ._parts import STEP_S, Valve

FIELD_S = 0.06
"""Time constant of its field, s; includes the residual field of the part."""
_SHARE = 1.0 - math.exp(-STEP_S / FIELD_S)
_HOLDS, _DROPS = 0.6, 0.1  # of its field: from here on it holds a part; less than this lets it fall
_STILL = 1e-6


class HoldingMagnet(Device):
    """A magnet that holds a part from 60 % of its field on, and drops it below 10 %.

    A part that sticks because of residual magnetism drops when it is blown off.

    Args:
        valve: switches its current, or the air that moves its magnets.
    """

    traits: ClassVar = frozenset({ACTUATOR, PARTS, STICKS})
    grips_bit: ClassVar = "part"
    released_bit: ClassVar = "gone"

    def __init__(self, valve: Valve | None = None, *, start: int = 0) -> None:
        super().__init__(valve or Valve(20_000), start)
        self.field = 0.0
        self._part, self._lost, self._holds, self._sticks = True, False, False, False
        self._blow_off = Valve(self.valve.delay_us)

    @property
    def pressure_kpa(self) -> None:
        return None

    @property
    def bits(self) -> Mapping[str, bool]:
        return {"part": self._holds, "gone": not self._holds}

    @property
    def settled(self) -> bool:
        falls = self._holds and self.field < _DROPS and not self._sticks
        return (
            not falls
            and self.valve.settled
            and self._blow_off.settled
            and abs(self._target - self.field) < _STILL
        )

    def command(self, active: bool, at: int) -> None:
        self._lost = self._lost and active
        super().command(active, at)

    def lose(self, at: int) -> None:
        """Tear off the part."""
        self._lost, self._holds = True, False

    def meet(self, part: bool) -> None:
        self._part = part
        self._holds = part and (self._holds or self.field >= _HOLDS)

    def stick(self, sticks: bool) -> None:
        self._sticks = sticks

    def blow(self, active: bool, at: int) -> None:
        self._blow_off.command(active, at)

    def settle(self, active: bool) -> None:
        self.valve.is_open = active
        self.field = self._target
        self._holds = self._part and active

    def step(self) -> None:
        self.valve.advance(self.now)
        self._blow_off.advance(self.now)
        self.field += (self._target - self.field) * _SHARE
        if self.field >= _HOLDS and self._part and not self._lost:
            self._holds = True
        elif self.field < _DROPS and (self._blow_off.is_open or not self._sticks):
            self._holds = False

    @property
    def _target(self) -> float:
        return 1.0 if self.valve.is_open else 0.0
