"""Records of a run: written as it happens, read back, and told in words."""

from ._files import append_whole, lock
from ._limits import RecordingLimits
from ._of_model import COUNTEREXAMPLE, MODEL_RUN, check_replaceable
from ._recording import Recording, content_hash, hash_of, pressure_channels, product_version, run_info
from ._run import RunInfo, read_run
from ._run_table import write_run_table
from ._watched import Watched
from .comparison import RunDifference, RunTables, Tolerances, compare_runs, read_tables
from .story import (
    AttemptOutcome,
    Grip,
    GripDecision,
    Moment,
    ReleaseCause,
    Story,
    read_story,
)
from .tables import (
    BEGUN,
    AlarmRow,
    AlarmsWriter,
    ChangerRow,
    ChangerWriter,
    PressuresLog,
    PressuresWriter,
    StatesLog,
    StatesRow,
    StatesWriter,
    SwitchesLog,
    SwitchesWriter,
    read_alarms,
    read_changer,
    read_pressures,
    read_states,
    read_switches,
)
from .trace import Gap, Opening, Record, TraceFile, TraceWriter, read_trace

__all__ = [
    "BEGUN",
    "COUNTEREXAMPLE",
    "MODEL_RUN",
    "AlarmRow",
    "AlarmsWriter",
    "AttemptOutcome",
    "ChangerRow",
    "ChangerWriter",
    "Gap",
    "Grip",
    "GripDecision",
    "Moment",
    "Opening",
    "PressuresLog",
    "PressuresWriter",
    "Record",
    "Recording",
    "RecordingLimits",
    "ReleaseCause",
    "RunDifference",
    "RunInfo",
    "RunTables",
    "StatesLog",
    "StatesRow",
    "StatesWriter",
    "Story",
    "SwitchesLog",
    "SwitchesWriter",
    "Tolerances",
    "TraceFile",
    "TraceWriter",
    "Watched",
    "append_whole",
    "check_replaceable",
    "compare_runs",
    "content_hash",
    "hash_of",
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
    "read_tables",
    "read_trace",
    "run_info",
    "write_run_table",
]
