"""What brings the readings of a tool: its sensor link, the inputs of its board, or both."""

from ._frame_order import FrameOrder
from ._reader import SensorHealth, SensorReader
