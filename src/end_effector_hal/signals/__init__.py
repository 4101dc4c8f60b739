"""What comes in from the wires, before anybody judges it: frames, streaks, trends, stamps; pure."""

from ._frame import Frame, Kind, Value
from ._memory import INLINE, PART, clone, memory_of, recall, same_memory
from ._readings import ChannelReadings
from ._stamps import StampGate
from ._streak import Streak
from ._trend import Trend

__all__ = [
    "INLINE",
    "PART",
    "ChannelReadings",
    "Frame",
    "Kind",
    "StampGate",
    "Streak",
    "Trend",
    "Value",
    "clone",
    "memory_of",
    "recall",
    "same_memory",
]
