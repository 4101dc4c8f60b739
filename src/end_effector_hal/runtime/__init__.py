"""A tool at work: its description, automata and wires put together, in real time.

Packages, of which an upper one imports those below it: ``tool``, a whole end-effector in one process; ``programs``,
a controller with its thread; ``boundary``, the recorded inputs and outputs of the program; ``outputs``, from
statuses to writes.
"""

from ._reload import reload_answer
from ._script import WORDS, ScriptCommand, read_command, read_script
from .programs import (
    InlineWorker,
    Program,
    longest_release_s,
    open_program,
    release_is_decided,
)
from .tool import (
    EndEffector,
    GoalRunner,
    Refused,
    RemoteTool,
    Result,
    RunningGoal,
    Tool,
    changer_is_sensed,
    latch_stop,
    reset,
    silent_links,
    stop,
)

__all__ = [
    "WORDS",
    "EndEffector",
    "GoalRunner",
    "InlineWorker",
    "Program",
    "Refused",
    "RemoteTool",
    "Result",
    "RunningGoal",
    "ScriptCommand",
    "Tool",
    "changer_is_sensed",
    "latch_stop",
    "longest_release_s",
    "open_program",
    "read_command",
    "read_script",
    "release_is_decided",
    "reload_answer",
    "reset",
    "silent_links",
    "stop",
]
