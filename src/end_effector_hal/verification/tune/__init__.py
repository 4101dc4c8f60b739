"""What recorded grips of a real tool say of its thresholds and time-outs; it suggests nothing."""

from ._attempts import MOST_GRIPS, MOST_READINGS, GripCollector, ReadingsThen, RecordedAttempt, RecordedGrip
from ._course import Course, GripOutcome, course_of, outcome_of
from ._parameters import TunableKey, not_tried, parameters_of
from ._tune import Counts, Tried, Tuning, tune

__all__ = [
    "MOST_GRIPS",
    "MOST_READINGS",
    "Counts",
    "Course",
    "GripCollector",
    "GripOutcome",
    "ReadingsThen",
    "RecordedAttempt",
    "RecordedGrip",
    "Tried",
    "TunableKey",
    "Tuning",
    "course_of",
    "not_tried",
    "outcome_of",
    "parameters_of",
    "tune",
]
