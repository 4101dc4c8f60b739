"""The words of a cylinder for the integers of Table II."""

from end_effector_hal.vocabulary import TableState


class CylinderState(TableState):
    """A pneumatic cylinder."""

    RETRACTED = 0
    PENDING_EXTEND = 1
    EXTENDED = 2
