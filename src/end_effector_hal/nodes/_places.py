"""The positions of cylinders and of the tool changer, as the sensors prove them."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum

from end_effector_hal.description import ToolChanger
from end_effector_hal.signals import Value
from end_effector_hal.vocabulary import Evidence


class CylinderPlace(IntEnum):
    """The position of a cylinder (``CylinderPosition``)."""

    UNKNOWN = 0
    RETRACTED = 1
    BETWEEN = 2
    EXTENDED = 3


class ChangerPlace(IntEnum):
    """The position of the tool changer (``ToolChangerPosition``)."""

    UNKNOWN = 0
    LOCKED = 1
    UNLOCKED = 2
    BETWEEN = 3
    CONTRADICTORY = 4


CYLINDER = {
    Evidence.UNKNOWN: CylinderPlace.UNKNOWN,
    Evidence.GONE: CylinderPlace.RETRACTED,
    Evidence.PARTIAL: CylinderPlace.BETWEEN,
    Evidence.CONFIRMED: CylinderPlace.EXTENDED,
}
"""The position of a cylinder, by the evidence of its actuator."""
_CHANGER = {
    (True, False): ChangerPlace.LOCKED,
    (False, True): ChangerPlace.UNLOCKED,
    (False, False): ChangerPlace.BETWEEN,
    (True, True): ChangerPlace.CONTRADICTORY,
}


def changer_place(changer: ToolChanger, values: Mapping[str, Value]) -> ChangerPlace:
    """Return the position of the tool changer, by its two bits."""
    locked, unlocked = values.get(changer.locked_bit), values.get(changer.unlocked_bit)
    if locked is None or unlocked is None:
        return ChangerPlace.UNKNOWN
    return _CHANGER[bool(locked), bool(unlocked)]
