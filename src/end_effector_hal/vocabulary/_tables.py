"""The integers of Table II of the paper, as they are logged. Their values never change meaning."""

from __future__ import annotations

from enum import IntEnum
from typing import Self

from end_effector_hal.errors import UsageError

_LABELS = {"STAND_BY": "STAND-BY"}


class TableState(IntEnum):
    """A state of Table II: an integer, its name (``STAND_BY``) and the paper's spelling (``STAND-BY``)."""

    @property
    def label(self) -> str:
        """The state's name as the paper prints it, for figures and sentences."""
        return _LABELS.get(self.name, self.name.replace("_", " "))

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
