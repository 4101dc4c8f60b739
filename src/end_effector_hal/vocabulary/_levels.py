"""What the sensors say, in the words of the UPPAAL file's interface."""

from __future__ import annotations

from enum import IntEnum

from ._tables import TableState


class Evidence(IntEnum):
    """What the sensors say of one actuator; ``evidence[i]`` of the model."""

    UNKNOWN = 0
    """Not read yet, stale, or invalid: never the last value."""
    GONE = 1
    PARTIAL = 2
    """Something is there, but it proves nothing."""
    CONFIRMED = 3


class ToolEvidence(IntEnum):
    """What the sensors say of the tool changer; ``tool`` of the model."""

    UNCLEAR = 0
    LOCKED = 1
    UNLOCKED = 2
    FAULTY = 3
    """Both bits or neither, for too long (IL-04)."""
    ABSENT = 4
    """Not unlocked, and a sensor shows that there is no tool (IL-05)."""


class ChangerState(TableState):
    """Where the tool changer is; ``changer`` of the model. Its words are those of figures too."""

    UNKNOWN = 0
    LOCKED = 1
    UNLOCKED = 2
    UNLOCKING = 3
    LOCKING = 4
    FAULT = 5


class Cause(IntEnum):
    """Why a grip or a release ended as it did; ``cause`` of the model."""

    NONE = 0
    TIMED_OUT = 1
    LOST = 2
    CANCELLED = 3
    STILL_PRESENT = 4
    NOT_PROVEN = 5
    UNPROVEN_AT_START = 6
    REFUSED = 7
    """The line arbiter refused to activate an output."""
    RELEASED_AT_START = 8
    """Outputs were found active and are deactivated, as declared."""
    KEPT = 9
    """An unwinding has left outputs active, as declared; why it began was told before."""
    EMPTY = 10
    """Each attempt was over, the last one because it had gripped nothing."""


class ChangerFault(IntEnum):
    """Why the tool changer is FAULT; ``changer_fault`` of the model."""

    NONE = 0
    UNPROVEN = 1
    """Its sensors did not prove in time, or any longer, what it should be."""
    SENSOR = 2
    """Both bits or neither (IL-04): latched until a reset."""
