"""A tool put together: description, automata and wires, in real time."""

from ._arbiter import connect_arbiter, run_arbiter
from ._automata import load_automata
from ._end_effector import EndEffector
from ._error_text import error_text, sendable
from ._goal_runner import GoalRunner, Refused, Result, RunningGoal
from ._lines import arbiter_policy, output_lines, program_lines
from ._open_unit import open_unit
from ._orders import Order, read_order, read_script
from ._outputs import LineWriter
from ._reset import reset
from ._unit import Unit
from ._witness import Witness

__all__ = [
    "EndEffector",
    "GoalRunner",
    "LineWriter",
    "Order",
    "Refused",
    "Result",
    "RunningGoal",
    "Unit",
    "Witness",
    "arbiter_policy",
    "connect_arbiter",
    "error_text",
    "load_automata",
    "open_unit",
    "output_lines",
    "program_lines",
    "read_order",
    "read_script",
    "reset",
    "run_arbiter",
    "sendable",
]
