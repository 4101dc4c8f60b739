"""The discrete and the symbolic states of a network, each worked out once."""

from ._discrete import DiscreteSpace, Move
from ._firing import Action
from ._invariant_guarded import InvariantGuardedSpace
from ._sliced import SlicedSemantics
from ._symbolic import Form, PlannedMove, StateRecord, SymbolicSpace

__all__ = [
    "Action",
    "DiscreteSpace",
    "Form",
    "InvariantGuardedSpace",
    "Move",
    "PlannedMove",
    "SlicedSemantics",
    "StateRecord",
    "SymbolicSpace",
]
