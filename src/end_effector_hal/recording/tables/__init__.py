"""The CSV tables of a recording: states, pressures, alarms; written row by row, and read back."""

from ._alarms import BEGUN, AlarmRow, AlarmsWriter, read_alarms
from ._changer import ChangerRow, ChangerWriter, read_changer
from ._pressures import KPA, PressuresLog, PressuresWriter, column_of, read_pressures
from ._states import StatesLog, StatesRow, StatesWriter, read_states

__all__ = [
    "BEGUN",
    "KPA",
    "AlarmRow",
    "AlarmsWriter",
    "ChangerRow",
    "ChangerWriter",
    "PressuresLog",
    "PressuresWriter",
    "StatesLog",
    "StatesRow",
    "StatesWriter",
    "column_of",
    "read_alarms",
    "read_changer",
    "read_pressures",
    "read_states",
]
