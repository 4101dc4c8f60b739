"""How a jaw behaves, for the testbench."""

from __future__ import annotations

from collections.abc import Mapping

from end_effector_lab.testbench.physics import STEP_S, Device, Valve

TRAVEL_S = 0.3


class JawPhysics(Device):
    """Jaws between two switches; on their way neither is made."""

    def __init__(self, valve: Valve, start: int = 0) -> None:
        super().__init__(valve, start)
        self.position = 0.0  # 0 open, 1 closed

    @property
    def bits(self) -> Mapping[str, bool]:
        """What ``closed_bit`` and ``open_bit`` show."""
        return {"closed": self.position >= 1.0, "open": self.position <= 0.0}

    @property
    def settled(self) -> bool:
        """Whether nothing moves."""
        return self.valve.settled and self.position == (1.0 if self.valve.is_open else 0.0)

    def settle(self, active: bool) -> None:
        """Stand at an end of the way."""
        self.valve.settle(active)
        self.position = 1.0 if active else 0.0

    def step(self) -> None:
        """A millisecond of travel."""
        way = STEP_S / TRAVEL_S
        if self.valve.advance(self.now):
            self.position = min(self.position + way, 1.0)
        else:
            self.position = max(self.position - way, 0.0)
