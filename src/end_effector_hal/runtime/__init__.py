"""A tool put together: description, automata and wires, in real time."""

from ._arbiter import connect_arbiter, run_arbiter
from ._automata import load_automata
from ._changer_program import ChangerProgram
from ._end_effector import EndEffector
from ._error_text import error_text, sendable
from ._goal_runner import GoalRunner, Refused, Result, RunningGoal
from ._grip_program import GripProgram
from ._lines import arbiter_policy, output_lines, program_lines, wired_lines
from ._open_program import open_program
from ._outputs import LineWriter
from ._predicate_publisher import PredicatePublisher
from ._program import Program
from ._ready import changer_is_sensed
from ._reset import reset
from ._script import ScriptCommand, read_command, read_script

__all__ = [
    "ChangerProgram",
    "EndEffector",
    "GoalRunner",
    "GripProgram",
    "LineWriter",
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
    "load_automata",
    "open_program",
    "output_lines",
    "program_lines",
    "read_command",
    "read_script",
    "reset",
    "run_arbiter",
    "sendable",
    "wired_lines",
]
