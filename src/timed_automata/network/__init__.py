"""A network of timed automata, made from a document, and its semantics, which all users share."""

from ._loader import export, load_network, make_network
from ._network import Edge, Given, Location, Network, Process, State, effects_of
from ._semantics import Fired, Semantics, Transition
from ._trace import Change, Trace, TraceStep, changes_between

__all__ = [
    "Change",
    "Edge",
    "Fired",
    "Given",
    "Location",
    "Network",
    "Process",
    "Semantics",
    "State",
    "Trace",
    "TraceStep",
    "Transition",
    "changes_between",
    "effects_of",
    "export",
    "load_network",
    "make_network",
]
