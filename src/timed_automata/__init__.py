"""Networks of timed automata from UPPAAL files: read, executed and written back here, and used by the rooms.

Faults of a file: ``timed_automata.check``; runs: ``simulate``; proofs: ``explore``; judging what happened: ``monitor``.
"""

from .document import (
    Document,
    DrawnEdge,
    DrawnLocation,
    Label,
    Template,
    load_document,
    load_source,
    read_document,
    write_document,
)
from .execute import (
    Begun,
    Event,
    Execution,
    ExecutionSnapshot,
    Observation,
    Reaction,
    Received,
    Step,
    TakenEdge,
    Written,
)
from .network import Change, Network, State, Trace, TraceStep, export, load_network, make_network

__all__ = [
    "Begun",
    "Change",
    "Document",
    "DrawnEdge",
    "DrawnLocation",
    "Event",
    "Execution",
    "ExecutionSnapshot",
    "Label",
    "Network",
    "Observation",
    "Reaction",
    "Received",
    "State",
    "Step",
    "TakenEdge",
    "Template",
    "Trace",
    "TraceStep",
    "Written",
    "export",
    "load_document",
    "load_network",
    "load_source",
    "make_network",
    "read_document",
    "write_document",
]
