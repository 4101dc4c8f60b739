"""The node Grip, which executes the automata of the tool."""

from ._grip import GripNode
