"""A tool put together: description, automata and wires, in real time."""

from ._automata import load_automata
from ._end_effector import EndEffector
from ._error_text import error_text, sendable
from ._goal_runner import GoalRunner, Refused, Result, RunningGoal
from ._lines import output_lines, owner_policy, program_lines
from ._open_unit import open_unit
from ._orders import Order, read_order, read_script
from ._outputs import LineWriter
from ._owner import connect_owner, run_owner
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
    "connect_owner",
    "error_text",
    "load_automata",
    "open_unit",
    "output_lines",
    "owner_policy",
    "program_lines",
    "read_order",
    "read_script",
    "reset",
    "run_owner",
    "sendable",
]
