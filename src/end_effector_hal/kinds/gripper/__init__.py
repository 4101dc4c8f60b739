"""The kind ``gripper``: fingers with an open and a closed end switch, a part switch, or all three."""

from ._kind import Gripper, GripperState
from ._stanza import GripperActuator

__all__ = ["Gripper", "GripperActuator", "GripperState"]
