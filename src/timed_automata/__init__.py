"""Networks of timed automata from UPPAAL files: read, checked, executed, written back. Knows nothing of grippers."""

from ._constraints import Bound, ClockConstraint, Condition, Relation, Values
from ._document import Document, DrawnEdge, DrawnLocation, Label, Query, Template
from ._execution import Execution
from ._expressions import Expressions, Term
from ._faults import did_you_mean, fault, refused
from ._initialisers import Given
from ._loader import load_network, make_network
from ._network import Channel, Edge, Location, Network, Process, State, Variable, effects_of
from ._parser import parse_expression
from ._quantifiers import quantified, unrolled
from ._schedule import NEVER, Clocks
from ._scope import Clock, Effects, Function, Scope, Storage
from ._semantics import Fired, Semantics, Transition
from ._sides import Sides
from ._snapshots import Resumed, resume, snapshot_of
from ._steps import (
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
from ._text import Span, Text
from ._unit import Unit
from ._values import Indexed, Value
from ._xml_reader import load_document, read_document
from ._xml_writer import export, write_document

__all__ = [
    "NEVER",
    "Begun",
    "Bound",
    "Change",
    "Channel",
    "Clock",
    "ClockConstraint",
    "Clocks",
    "Condition",
    "Document",
    "DrawnEdge",
    "DrawnLocation",
    "Edge",
    "Effects",
    "Event",
    "Execution",
    "ExecutionSnapshot",
    "Expressions",
    "Fired",
    "Function",
    "Given",
    "Indexed",
    "Label",
    "Location",
    "Network",
    "Observation",
    "Process",
    "Query",
    "Reaction",
    "Received",
    "Relation",
    "Resumed",
    "Scope",
    "Semantics",
    "Sides",
    "Span",
    "State",
    "Step",
    "Storage",
    "TakenEdge",
    "Template",
    "Term",
    "Text",
    "Transition",
    "Unit",
    "Value",
    "Values",
    "Variable",
    "Written",
    "did_you_mean",
    "effects_of",
    "export",
    "fault",
    "load_document",
    "load_network",
    "make_network",
    "parse_expression",
    "quantified",
    "read_document",
    "refused",
    "resume",
    "snapshot_of",
    "unrolled",
    "write_document",
]
