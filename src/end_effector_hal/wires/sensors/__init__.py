"""What brings the readings of a tool: its sensor link, the inputs of its board, or both."""

from ._reader import FrameOrder, SensorHealth, SensorReader
