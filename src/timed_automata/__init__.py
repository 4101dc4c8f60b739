"""Networks of timed automata from UPPAAL files: read, checked, executed, written back. Knows nothing of grippers."""

from ._boundary import ExecutionBoundary
from ._clocks import NEVER, ClockInstants
from ._conditions import Bound, ClockConstraint, Condition, Relation, Values
from ._document import Document, DrawnEdge, DrawnLocation, Label, StoredQuery, Template
from ._execution import Execution
from ._expressions import Expressions
from ._faults import did_you_mean, fault, refused
from ._generated_code import GeneratedCode
from ._given import Given
from ._loader import export, load_network, make_network
from ._network import Channel, Edge, Location, Network, Process, State, Variable, effects_of
from ._parser import parse_expression
from ._scope import ClockSymbol, Effects, Function, Scope, Storage
from ._semantics import Fired, Semantics, Transition
from ._snapshots import Resumed, resume, snapshot_of
from ._steps import (
    Begun,
    Event,
    ExecutionSnapshot,
    Observation,
    Reaction,
    Received,
    Step,
    TakenEdge,
    Written,
)
from ._terms import IndexedTerm, Term
from ._text import Span, Text
from ._trace import Change
from ._values import Value
from ._xml_reader import load_document, read_document
from ._xml_writer import write_document

__all__ = [
    "NEVER",
    "Begun",
    "Bound",
    "Change",
    "Channel",
    "ClockConstraint",
    "ClockInstants",
    "ClockSymbol",
    "Condition",
    "Document",
    "DrawnEdge",
    "DrawnLocation",
    "Edge",
    "Effects",
    "Event",
    "Execution",
    "ExecutionBoundary",
    "ExecutionSnapshot",
    "Expressions",
    "Fired",
    "Function",
    "GeneratedCode",
    "Given",
    "IndexedTerm",
    "Label",
    "Location",
    "Network",
    "Observation",
    "Process",
    "Reaction",
    "Received",
    "Relation",
    "Resumed",
    "Scope",
    "Semantics",
    "Span",
    "State",
    "Step",
    "Storage",
    "StoredQuery",
    "TakenEdge",
    "Template",
    "Term",
    "Text",
    "Transition",
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
    "read_document",
    "refused",
    "resume",
    "snapshot_of",
    "write_document",
]
