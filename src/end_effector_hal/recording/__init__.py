"""Write the recording of a run as the run happens, read it back, and describe it in words."""

from ._alarms import BEGUN, ENDED, AlarmRow, changed_alarms, read_alarms
from ._compare import RunTables, Tolerances, compare_runs
from ._compared_pressures import RunDifference, count_differences
from ._events import EventRow, EventsWriter, event_row
from ._files import RecordingLimits, RunFile, lock
from ._levels import ChangerRow, SwitchesLog, is_part_name, read_changer, read_switches
from ._of_tool import pressure_channels, product_version, run_info
from ._pressures import KPA, PressuresLog, last_pressures, read_pressures
from ._recording import Recording
from ._run import COUNTEREXAMPLE, MODEL_RUN, RunInfo, Watched, check_replaceable, read_run
from ._states import StatesLog, StatesRow, StatesWriter, read_states
from ._story import AttemptOutcome, Grip, GripDecision, Moment, ReleaseCause, Story
from ._story_reader import StoryFold, read_story
from ._trace_file import Record, TraceFile, read_trace
from ._trace_writer import Gap, Opening, TraceWriter

__all__ = [
    "BEGUN",
    "COUNTEREXAMPLE",
    "ENDED",
    "KPA",
    "MODEL_RUN",
    "AlarmRow",
    "AttemptOutcome",
    "ChangerRow",
    "EventRow",
    "EventsWriter",
    "Gap",
    "Grip",
    "GripDecision",
    "Moment",
    "Opening",
    "PressuresLog",
    "Record",
    "Recording",
    "RecordingLimits",
    "ReleaseCause",
    "RunDifference",
    "RunFile",
    "RunInfo",
    "RunTables",
    "StatesLog",
    "StatesRow",
    "StatesWriter",
    "Story",
    "StoryFold",
    "SwitchesLog",
    "Tolerances",
    "TraceFile",
    "TraceWriter",
    "Watched",
    "changed_alarms",
    "check_replaceable",
    "compare_runs",
    "count_differences",
    "event_row",
    "is_part_name",
    "last_pressures",
    "lock",
    "pressure_channels",
    "product_version",
    "read_alarms",
    "read_changer",
    "read_pressures",
    "read_run",
    "read_states",
    "read_story",
    "read_switches",
    "read_trace",
    "run_info",
]
