"""The integers of the program: those of Table II of the paper, and those of the UPPAAL file.

Table II is logged: its values never change meaning. The evidence of the sensors and the states of the tool changer are
numbered as in the UPPAAL file.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Self

from end_effector_hal.errors import UsageError


class TableState(IntEnum):
    """A state of Table II: an integer, and its name (``PENDING_ON``)."""

    @property
    def label(self) -> str:
        """The state's name for figures and sentences."""
        return self.name.replace("_", " ")

    @classmethod
    def named(cls, name: str) -> Self:
        """Return the state with this name or label, in any case; raises UsageError for an unknown one."""
        key = name.strip().upper().replace("-", "_").replace(" ", "_")
        if key not in cls.__members__:
            known = ", ".join(cls.__members__)
            raise UsageError(f"{name!r} is no state of {cls.__name__}.", todo=f"Known are {known}.")
        return cls[key]


class EndEffectorState(TableState):
    """State of the whole end-effector; OFF: its outputs are not adopted yet, or it is shut down."""

    OFF = 0
    GRIPPING = 1
    GRIP_ERROR = 2
    GRIPPED = 3
    RELEASING = 4
    RELEASE_ERROR = 5
    STAND_BY = 6

    @property
    def label(self) -> str:
        """Its name, as commands, logs and ROS print it."""
        return self.name


class Command(TableState):
    """The command that the hardware abstraction layer is executing."""

    NONE = -1
    LOCK = 0
    UNLOCK = 1
    GRIP = 2
    RELEASE = 3
    CANCEL = 4
    QUIT = 5


class ActuatorState(TableState):
    """The states that all actuators have in common; each kind of device has its own names for the three."""

    INACTIVE = 0
    PENDING = 1
    ACTIVE = 2


INACTIVE, PENDING, ACTIVE = 0, 1, 2


def display_name(name: str) -> str:
    """Return a name as people read it: ``bottom_vacuum`` -> ``Bottom vacuum``."""
    words = name.replace("_", " ").strip()
    return words[:1].upper() + words[1:]


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
