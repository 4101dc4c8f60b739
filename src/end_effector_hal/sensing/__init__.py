"""The judgement of the sensors: rules of the link, predicates, the watch over a held part; sans-IO.

``detectors`` contains the detectors that belong to no kind of device; those of an actuator belong to its kind.
"""

from ._hold_monitor import HoldMonitor
from ._predicates import (
    E_STOP_CLOSED,
    LOCKED,
    NO_FAULT,
    NO_LATCHED_FAULT,
    NOTHING_GRIPPED,
    PARKED,
    PRESENT,
    Predicates,
    predicates_fitted,
    proven_by_arbiter,
)
from ._readings import JudgedReadings, Readings, ToolPlace, tool_place
from ._sensor_set import SENT_INVALID, SensorSet, why_invalid
from ._sensor_state import SensorState, stays

__all__ = [
    "E_STOP_CLOSED",
    "LOCKED",
    "NOTHING_GRIPPED",
    "NO_FAULT",
    "NO_LATCHED_FAULT",
    "PARKED",
    "PRESENT",
    "SENT_INVALID",
    "HoldMonitor",
    "JudgedReadings",
    "Predicates",
    "Readings",
    "SensorSet",
    "SensorState",
    "ToolPlace",
    "predicates_fitted",
    "proven_by_arbiter",
    "stays",
    "tool_place",
    "why_invalid",
]
