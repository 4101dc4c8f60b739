"""Records of a run: written as it happens, read back, told in words and drawn."""

from end_effector_hal.trace._alarms import AlarmRow, AlarmsWriter, read_alarms
from end_effector_hal.trace._draw import paper, save, timeline
from end_effector_hal.trace._limits import RecordingLimits
from end_effector_hal.trace._pressures import PressuresLog, PressuresWriter, read_pressures
from end_effector_hal.trace._run import RunInfo, read_run
from end_effector_hal.trace._states import StatesLog, StatesRow, StatesWriter, read_states
from end_effector_hal.trace._story import (
    Attempt,
    Cause,
    Decision,
    Grip,
    Moment,
    Outcome,
    Release,
    Reset,
    Story,
)
from end_effector_hal.trace._tables import (
    Command,
    CylinderState,
    EndEffectorState,
    TableState,
    VacuumState,
    actuator_states,
    display_name,
)
from end_effector_hal.trace._tell import tell
from end_effector_hal.trace._trace_file import Record, TraceFile, read_trace
from end_effector_hal.trace._trace_writer import Entry, Gap, Opening, TraceWriter

__all__ = [
    "AlarmRow",
    "AlarmsWriter",
    "Attempt",
    "Cause",
    "Command",
    "CylinderState",
    "Decision",
    "EndEffectorState",
    "Entry",
    "Gap",
    "Grip",
    "Moment",
    "Opening",
    "Outcome",
    "PressuresLog",
    "PressuresWriter",
    "Record",
    "RecordingLimits",
    "Release",
    "Reset",
    "RunInfo",
    "StatesLog",
    "StatesRow",
    "StatesWriter",
    "Story",
    "TableState",
    "TraceFile",
    "TraceWriter",
    "VacuumState",
    "actuator_states",
    "display_name",
    "paper",
    "read_alarms",
    "read_pressures",
    "read_run",
    "read_states",
    "read_trace",
    "save",
    "tell",
    "timeline",
]
