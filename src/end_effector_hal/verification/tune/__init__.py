"""What recorded grips of a real tool say of its thresholds and time-outs; it suggests nothing."""

from ._attempts import GripCollector
from ._course import course_of
from ._parameters import TunableKey, not_tried, parameters_of
from ._tune import Tried, Tuning, tune
