"""Input from the sensor links before any judgement: frames, streaks, trends and time stamps; no I/O."""

from ._frame import Frame, Kind, Value
from ._measure import GAUGE_PRESSURE, Measure, MeasuredReadings
from ._memory import INLINE, PART, clone, memory_of, recall
from ._readings import ChannelReadings, PassingReadings
from ._stamps import StampGate
from ._streak import Streak, lengthen, streaks_of
from ._trend import Trend

__all__ = [
    "GAUGE_PRESSURE",
    "INLINE",
    "PART",
    "ChannelReadings",
    "Frame",
    "Kind",
    "Measure",
    "MeasuredReadings",
    "PassingReadings",
    "StampGate",
    "Streak",
    "Trend",
    "Value",
    "clone",
    "lengthen",
    "memory_of",
    "recall",
    "streaks_of",
]
