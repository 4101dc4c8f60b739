"""A tool put together: description, automata and wires, in real time.

Rooms, the upper of which import the lower: ``tool``, a whole end-effector in one process; ``programs``, controllers
with a thread each; ``boundary``, what goes in and out of them, recorded; ``outputs``, from statuses to writes;
``arbiter``, what the line arbiter is given of a tool.
"""

from ._automata import load_automata
from ._error_text import error_text, sendable
from ._reload import fixed_by_arbiter, reload_answer
from ._script import WORDS, ScriptCommand, read_command, read_script
from .arbiter import (
    SENSOR_FAULT,
    PredicatePublisher,
    arbiter_policy,
    connect_arbiter,
    output_lines,
    program_lines,
    run_arbiter,
    wired_lines,
)
from .outputs import LineWriter
from .programs import (
    ChangerProgram,
    GripProgram,
    InlineWorker,
    Program,
    longest_release_s,
    open_program,
    release_is_decided,
)
from .tool import (
    EndEffector,
    GoalRunner,
    PlainOutputs,
    Refused,
    Result,
    RunningGoal,
    changer_is_sensed,
    latch_stop,
    reset,
    stop,
)

__all__ = [
    "SENSOR_FAULT",
    "WORDS",
    "ChangerProgram",
    "EndEffector",
    "GoalRunner",
    "GripProgram",
    "InlineWorker",
    "LineWriter",
    "PlainOutputs",
    "PredicatePublisher",
    "Program",
    "Refused",
    "Result",
    "RunningGoal",
    "ScriptCommand",
    "arbiter_policy",
    "changer_is_sensed",
    "connect_arbiter",
    "error_text",
    "fixed_by_arbiter",
    "latch_stop",
    "load_automata",
    "longest_release_s",
    "open_program",
    "output_lines",
    "program_lines",
    "read_command",
    "read_script",
    "release_is_decided",
    "reload_answer",
    "reset",
    "run_arbiter",
    "sendable",
    "stop",
    "wired_lines",
]
