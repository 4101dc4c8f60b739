"""Networks of timed automata from UPPAAL files: read, checked, executed, written back. Knows nothing of grippers."""

from end_effector_hal.automata._constraints import Bound, ClockConstraint, Condition
from end_effector_hal.automata._document import Document
from end_effector_hal.automata._execution import Execution
from end_effector_hal.automata._loader import load_network, make_network
from end_effector_hal.automata._network import Channel, Edge, Location, Network, Process, State, Variable
from end_effector_hal.automata._semantics import Fired, Semantics, Transition
from end_effector_hal.automata._steps import (
    Begun,
    Change,
    Event,
    ExecutionSnapshot,
    Observation,
    Reaction,
    Received,
    Step,
    TakenEdge,
    Written,
)
from end_effector_hal.automata._xml_reader import load_document, read_document
from end_effector_hal.automata._xml_writer import export, write_document
from end_effector_hal.errors import RangeError

__all__ = [
    "Begun",
    "Bound",
    "Change",
    "Channel",
    "ClockConstraint",
    "Condition",
    "Document",
    "Edge",
    "Event",
    "Execution",
    "ExecutionSnapshot",
    "Fired",
    "Location",
    "Network",
    "Observation",
    "Process",
    "RangeError",
    "Reaction",
    "Received",
    "Semantics",
    "State",
    "Step",
    "TakenEdge",
    "Transition",
    "Variable",
    "Written",
    "export",
    "load_document",
    "load_network",
    "make_network",
    "read_document",
    "write_document",
]
