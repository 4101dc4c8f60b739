"""What a pressure channel can show at all: beyond that a sensor or its wiring is broken."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class PressureRange:
    """Gauge kPa from ``low`` to ``high``; ``what`` is measured, for a sentence."""

    low: float
    high: float
    what: str

    def has(self, pascal: int) -> bool:
        """Whether the circuit can have this pressure."""
        return self.low * 1000 <= pascal <= self.high * 1000

    def fault(self, channel: str, pascal: int) -> str:
        """Why a value is none."""
        limits = f"{self.low:g} to {self.high:g} kPa"
        return (
            f"The channel {channel} shows {pascal / 1000:.0f} kPa, which {self.what} cannot have ({limits}): "
            "it counts as invalid. Is its sensor broken, or exchanged with another?"
        )


def below_ambient_kpa(value: int | bool) -> float:
    """The vacuum that a reading shows; a switch shows all or nothing."""
    if isinstance(value, bool):
        return 100.0 if value else 0.0
    return -value / 1000


COMPRESSED_AIR = PressureRange(-10.0, 2000.0, "compressed air")
"""A transmitter may be a few kPa off."""
