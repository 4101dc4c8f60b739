"""How far the pressure of an actuator is from the threshold that matters."""

from __future__ import annotations

from end_effector_hal.description import Actuator, Supply, VacuumActuator


def margin_pa(part: Actuator, supply: Supply, gauge_pa: float, supply_pa: float | None = None) -> float:
    """Pa beyond the threshold of loss (vacuum) or of confirmation (cylinder); negative: on the wrong side.

    Args:
        part: the actuator.
        supply: the compressed air of the tool.
        gauge_pa: its pressure, vacuum negative.
        supply_pa: that of the supply, gauge; None: not known, its nominal pressure counts.
    """
    if isinstance(part, VacuumActuator):
        return -gauge_pa - part.lost_kpa * 1000
    reference_pa = supply.nominal_kpa * 1000 if supply_pa is None else supply_pa
    return gauge_pa - part.extended_fraction * reference_pa
