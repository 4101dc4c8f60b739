"""A tool put together: description, automata, wires; one unit per program, and both in one process."""

from end_effector_hal.control import Answer, Status, StepReport

from ._automata import load_automata
from ._end_effector import EndEffector, Outcome
from ._lines import output_lines, owner_policy, program_lines
from ._open_unit import open_unit
from ._orders import Order, read_order, read_script
from ._outputs import LineWriter
from ._owner import connect_owner, run_owner
from ._recording import Recording, content_hash, run_info
from ._reset import reset
from ._unit import Unit
from ._witness import Witness

__all__ = [
    "Answer",
    "EndEffector",
    "LineWriter",
    "Order",
    "Outcome",
    "Recording",
    "Status",
    "StepReport",
    "Unit",
    "Witness",
    "connect_owner",
    "content_hash",
    "load_automata",
    "open_unit",
    "output_lines",
    "owner_policy",
    "program_lines",
    "read_order",
    "read_script",
    "reset",
    "run_info",
    "run_owner",
]
