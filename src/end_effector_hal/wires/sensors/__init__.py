"""The sources of a tool's readings: its sensor links, the inputs of its board, or both."""

from ._reader import FrameOrder, SensorHealth, SensorReader
