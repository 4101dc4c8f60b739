"""A tool put together: description, automata and wires, in real time.

Rooms, the upper of which import the lower: ``tool``, a whole end-effector in one process; ``programs``, controllers
with a thread each; ``boundary``, what goes in and out of them, recorded; ``outputs``, from statuses to writes.
"""

from ._automata import load_automata
from ._error_text import error_text, sendable
from ._reload import fixed_by_arbiter, reload_answer
from ._script import WORDS, ScriptCommand, read_command, read_script
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
    "WORDS",
    "ChangerProgram",
    "EndEffector",
    "GoalRunner",
    "GripProgram",
    "InlineWorker",
    "LineWriter",
    "PlainOutputs",
    "Program",
    "Refused",
    "Result",
    "RunningGoal",
    "ScriptCommand",
    "changer_is_sensed",
    "error_text",
    "fixed_by_arbiter",
    "latch_stop",
    "load_automata",
    "longest_release_s",
    "open_program",
    "read_command",
    "read_script",
    "release_is_decided",
    "reload_answer",
    "reset",
    "sendable",
    "stop",
]
