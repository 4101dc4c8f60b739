"""The CSV tables of a recording: states, pressures, alarms; written row by row, and read back."""

from ._alarms import BEGUN, AlarmRow, AlarmsWriter, read_alarms
from ._pressures import PressuresLog, PressuresWriter, read_pressures
from ._states import StatesLog, StatesRow, StatesWriter, read_states

__all__ = [
    "BEGUN",
    "AlarmRow",
    "AlarmsWriter",
    "PressuresLog",
    "PressuresWriter",
    "StatesLog",
    "StatesRow",
    "StatesWriter",
    "read_alarms",
    "read_pressures",
    "read_states",
]
