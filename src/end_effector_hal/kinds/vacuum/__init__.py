"""The kind ``vacuum``: a generator with its cups, and a pressure sensor or switch."""

from ._kind import Vacuum, VacuumState
from ._stanza import VacuumActuator
