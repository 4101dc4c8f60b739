"""The words of a vacuum for the integers of Table II."""

from end_effector_hal.vocabulary import TableState


class VacuumState(TableState):
    """A vacuum generator with its cups."""

    OFF = 0
    PENDING_ON = 1
    ON = 2
