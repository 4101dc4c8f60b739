"""Which channels prove something of an actuator."""

from __future__ import annotations

from end_effector_hal.description import Actuator, CylinderActuator


def channels_of(actuator: Actuator) -> tuple[str, ...]:
    """Every channel that can prove something of an actuator."""
    if isinstance(actuator, CylinderActuator):
        bits = (actuator.extended_bit, actuator.retracted_bit)
        return (actuator.channel, *(bit for bit in bits if bit))
    return (actuator.channel,)
