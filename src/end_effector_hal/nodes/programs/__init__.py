"""The nodes that execute automata: Grip and ToolChange."""

from ._grip import GripNode
from ._tool_change import ToolChangeNode
