"""What comes in from the wires, before anybody judges it: frames, streaks, trends, stamps; pure."""

from ._frame import Frame, Kind, Value
from ._memory import PART, memory_of, recall
from ._stamps import StampGate
from ._streak import Streak
from ._trend import Trend

__all__ = ["PART", "Frame", "Kind", "StampGate", "Streak", "Trend", "Value", "memory_of", "recall"]
