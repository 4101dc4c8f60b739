"""What a pressure channel can show at all: beyond that a sensor or its wiring is broken."""

from __future__ import annotations

from dataclasses import dataclass

from end_effector_hal.description import Description, VacuumActuator

# Ambient pressure is 101 kPa at most at sea level; a transmitter may be a few kPa off. What is left of a vacuum that
# is no longer "gone" must not pass for compressed air: then exchanged sensors would be believed.
LOWEST_VACUUM_KPA, HIGHEST_VACUUM_KPA = -110.0, 50.0
LOWEST_AIR_KPA, HIGHEST_AIR_KPA = -10.0, 2000.0


@dataclass(frozen=True, slots=True)
class Range:
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


def plausible_ranges(description: Description) -> dict[str, Range]:
    """By channel; a channel that is not named in the description has none."""
    air = Range(LOWEST_AIR_KPA, HIGHEST_AIR_KPA, "compressed air")
    ranges = {description.supply.channel: air}
    for _, part in description.ordered:
        # A blow-off puts compressed air into the vacuum circuit.
        blown = getattr(part, "blow_off", None) is not None
        high = HIGHEST_AIR_KPA if blown else HIGHEST_VACUUM_KPA
        vacuum = Range(LOWEST_VACUUM_KPA, high, "a vacuum circuit")
        ranges[part.channel] = vacuum if isinstance(part, VacuumActuator) else air
    return ranges
