"""How far the pressure of each actuator is from the threshold that matters."""

from __future__ import annotations

import math
from collections.abc import Collection

from end_effector_hal.description import Description
from end_effector_hal.kinds import fault_of, kind_of
from end_effector_hal.kinds.stanza import Actuator
from end_effector_hal.nodes.transport import AMBIENT_PA


class Margins:
    """The margin of each actuator in Pa, from the absolute pressures of the channels."""

    def __init__(self, description: Description) -> None:
        self._description = description
        self._supply = description.supply
        self._absolute: dict[str, float] = {}

    def store(self, channel: str, absolute_pa: float) -> None:
        """A reading was received; NaN: invalid."""
        self._absolute[channel] = absolute_pa

    def values(self, stale: Collection[str] | None) -> list[float]:
        """In the order of the sequence, NaN where nothing is known; ``stale``: channels, None: all."""
        return [self._margin(part, stale) for _, part in self._description.ordered]

    @property
    def alarms(self) -> tuple[str, ...]:
        """Kinds of somebody else's whose margins are not known because they have failed."""
        kinds = dict.fromkeys(kind_of(part) for _, part in self._description.ordered)
        return tuple(fault for kind in kinds if (fault := fault_of(kind)))

    def _margin(self, part: Actuator, stale: Collection[str] | None) -> float:
        supply_pa = self._supply.pressure_pa(self._gauge(self._supply.channel, stale))
        return kind_of(part).margin_pa(part, self._gauge(part.channel, stale), supply_pa)

    def _gauge(self, channel: str, stale: Collection[str] | None) -> float:
        if stale is None or channel in stale:
            return math.nan
        return self._absolute.get(channel, math.nan) - AMBIENT_PA
