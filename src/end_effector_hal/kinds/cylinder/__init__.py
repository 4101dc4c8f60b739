"""The kind ``cylinder``: a pneumatic cylinder with a pressure sensor, position bits, or both."""

from ._kind import Cylinder, CylinderState
from ._stanza import CylinderActuator
