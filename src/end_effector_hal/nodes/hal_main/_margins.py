"""How far the pressure of each actuator is from the threshold that matters."""

from __future__ import annotations

import math
from collections.abc import Collection

from end_effector_hal.description import Description
from end_effector_hal.kinds import fault_of, kind_of
from end_effector_hal.kinds.stanza import Actuator
from end_effector_hal.nodes.transport import AMBIENT_PA
from end_effector_hal.vocabulary import Alarm


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
    def alarms(self) -> tuple[Alarm, ...]:
        """One for each kind of a plug-in whose margins are not known because it has failed."""
        kinds = {part.kind: kind_of(part) for _, part in self._description.ordered}
        found = ((name, fault_of(kind)) for name, kind in kinds.items())
        return tuple(Alarm("kind.failed", name, {"why": fault}) for name, fault in found if fault)

    def _margin(self, part: Actuator, stale: Collection[str] | None) -> float:
        supply_pa = self._supply.pressure_pa(self._gauge(self._supply.channel, stale))
        return kind_of(part).margin_pa(part, self._gauge(part.channel, stale), supply_pa)

    def _gauge(self, channel: str, stale: Collection[str] | None) -> float:
        if stale is None or channel in stale:
            return math.nan
        return self._absolute.get(channel, math.nan) - AMBIENT_PA
