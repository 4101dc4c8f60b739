"""Where a part stands by its sensors alone, with the integers of the messages of positions."""

from enum import IntEnum


class CylinderPlace(IntEnum):
    """Where a cylinder stands (``CylinderPosition``)."""

    UNKNOWN = 0
    RETRACTED = 1
    BETWEEN = 2
    EXTENDED = 3


class ChangerPlace(IntEnum):
    """Where the tool changer stands (``ToolChangerPosition``)."""

    UNKNOWN = 0
    LOCKED = 1
    UNLOCKED = 2
    BETWEEN = 3
    CONTRADICTORY = 4
