"""The kind ``gripper``: fingers with an open and a closed end switch, a part switch, or all three."""

from ._kind import Gripper
