"""The kind ``vacuum``: a generator with its cups, and a pressure sensor or switch."""

from ._kind import Vacuum
from ._stanza import BlowOff, VacuumActuator
from ._states import VacuumState

__all__ = ["BlowOff", "Vacuum", "VacuumActuator", "VacuumState"]
