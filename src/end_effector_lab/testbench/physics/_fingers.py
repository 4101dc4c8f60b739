"""The fingers of a gripper, with a spring that opens them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from ._device import ACTUATOR, PARTS, Device
from ._parts import STEP_S, Valve

TRAVEL_S = 0.3
"""Time from open to fully closed, s; 0.03 to 0.5 s are usual."""
PART_AT = 0.6
"""Share of the travel at which a part stops the fingers."""
_SWITCH = 0.02  # an end switch is made over the last 2 % of the way
_TRAVEL = STEP_S / TRAVEL_S


class Fingers(Device):
    """Fingers that close on the part between them, or fully if there is none.

    Args:
        valve: closes them when open.
    """

    traits: ClassVar = frozenset({ACTUATOR, PARTS})
    grips_bit: ClassVar = "part"
    released_bit: ClassVar = "open"
    empty_bit: ClassVar = "closed"

    def __init__(self, valve: Valve | None = None, *, start: int = 0) -> None:
        super().__init__(valve or Valve(30_000), start)
        self.position = 0.0  # 0 open, 1 closed on nothing
        self._part = True
        self._lost = False

    @property
    def pressure_kpa(self) -> None:
        return None

    @property
    def bits(self) -> Mapping[str, bool]:
        return {
            "open": self.position <= _SWITCH,
            "closed": self.position >= 1 - _SWITCH,
            "part": self._on_part and self.position == PART_AT,
        }

    @property
    def settled(self) -> bool:
        return self.valve.settled and self.position == self._end

    def command(self, active: bool, at: int) -> None:
        self._lost = self._lost and active
        super().command(active, at)

    def lose(self, at: int) -> None:
        """Remove the part, pulled out or broken: the fingers close fully."""
        self._lost = True

    def meet(self, part: bool) -> None:
        self._part = part

    def settle(self, active: bool) -> None:
        self.valve.is_open = active
        self.position = self._end

    def step(self) -> None:
        self.valve.advance(self.now)
        if self.position < self._end:
            self.position = min(self.position + _TRAVEL, self._end)
        else:
            self.position = max(self.position - _TRAVEL, self._end)

    @property
    def _on_part(self) -> bool:
        return self._part and not self._lost

    @property
    def _end(self) -> float:
        if not self.valve.is_open:
            return 0.0
        return PART_AT if self._on_part else 1.0
