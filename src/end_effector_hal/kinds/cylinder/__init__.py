"""The kind ``cylinder``: a pneumatic cylinder with a pressure sensor, position bits, or both."""

from ._kind import Cylinder
from ._stanza import CylinderActuator
from ._states import CylinderState

__all__ = ["Cylinder", "CylinderActuator", "CylinderState"]
