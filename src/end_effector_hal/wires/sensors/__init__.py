"""Everything that brings readings of a tool: its sensor link, the inputs of its board."""

from ._reader import SensorReader

__all__ = ["SensorReader"]
