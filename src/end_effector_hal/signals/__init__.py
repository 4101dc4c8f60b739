"""What comes in from the wires, before anybody judges it: frames, streaks, trends, stamps; pure."""

from ._frame import Frame, Kind, Value
from ._memory import INLINE, PART, clone, memory_of, recall, same_memory
from ._stamps import StampGate
from ._streak import Streak
from ._trend import Trend

__all__ = [
    "INLINE",
    "PART",
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
