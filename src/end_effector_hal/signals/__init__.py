"""Input from the sensor links before any judgement: frames, streaks, trends and time stamps; no I/O."""

from ._memory import INLINE, NESTED, clone, memory_of, recall
from ._readings import (
    GAUGE_PRESSURE,
    ChannelReadings,
    Frame,
    Kind,
    Measure,
    MeasuredReadings,
    PassingReadings,
    Value,
)
from ._stamps import StampGate
from ._trend import Streak, Trend, lengthen, streaks_of

__all__ = [
    "GAUGE_PRESSURE",
    "INLINE",
    "NESTED",
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
