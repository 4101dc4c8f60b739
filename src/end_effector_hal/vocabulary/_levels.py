"""The evidence of the sensors and the states of the tool changer, numbered as in the UPPAAL file."""

from __future__ import annotations

from enum import IntEnum

from ._tables import TableState


class Evidence(IntEnum):
    """Evidence of the sensors about one actuator; ``evidence[i]`` of the model."""

    UNKNOWN = 0
    """Not read yet, stale, or invalid; the last value is never kept."""
    GONE = 1
    PARTIAL = 2
    """There is a signal, but it proves nothing."""
    CONFIRMED = 3


class ToolEvidence(IntEnum):
    """Evidence of the sensors about the tool changer; ``tool`` of the model."""

    UNCLEAR = 0
    LOCKED = 1
    UNLOCKED = 2
    FAULTY = 3
    """Both bits on or both off, for too long (IL-04)."""
    ABSENT = 4
    """Not unlocked, and a sensor shows that no tool is there (IL-05)."""


class ChangerState(TableState):
    """State of the tool changer; ``changer`` of the model. Figures use the same names."""

    UNKNOWN = 0
    LOCKED = 1
    UNLOCKED = 2
    UNLOCKING = 3
    LOCKING = 4
    FAULT = 5


class Cause(IntEnum):
    """Reason why a grip or a release ended; ``cause`` of the model."""

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
    """An unwinding has left outputs active, as declared; its reason was reported before."""
    EMPTY = 10
    """All attempts failed, the last one because the actuator had gripped nothing."""


class ChangerFault(IntEnum):
    """Reason why the tool changer is in FAULT; ``changer_fault`` of the model."""

    NONE = 0
    UNPROVEN = 1
    """Its sensors did not prove the expected state in time, or no longer prove it."""
    SENSOR = 2
    """Both bits on or both off (IL-04); latched until a reset."""
