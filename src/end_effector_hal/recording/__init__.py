"""Records of a run: written as it happens, read back, and told in words."""

from ._alarms import AlarmRow, AlarmsWriter, read_alarms
from ._limits import RecordingLimits
from ._pressures import PressuresLog, PressuresWriter, read_pressures
from ._recording import Recording, content_hash, product_version, run_info
from ._run import RunInfo, read_run
from ._states import StatesLog, StatesRow, StatesWriter, read_states
from ._story import Attempt, Cause, Decision, Grip, Moment, Outcome, Release, Reset, Story
from ._tell import tell
from ._trace_file import Record, TraceFile, read_trace
from ._trace_writer import Entry, Gap, Opening, TraceWriter

__all__ = [
    "AlarmRow",
    "AlarmsWriter",
    "Attempt",
    "Cause",
    "Decision",
    "Entry",
    "Gap",
    "Grip",
    "Moment",
    "Opening",
    "Outcome",
    "PressuresLog",
    "PressuresWriter",
    "Record",
    "Recording",
    "RecordingLimits",
    "Release",
    "Reset",
    "RunInfo",
    "StatesLog",
    "StatesRow",
    "StatesWriter",
    "Story",
    "TraceFile",
    "TraceWriter",
    "content_hash",
    "product_version",
    "read_alarms",
    "read_pressures",
    "read_run",
    "read_states",
    "read_trace",
    "run_info",
    "tell",
]
