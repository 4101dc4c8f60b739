"""The discrete and the symbolic states of a network, each worked out once."""

from ._discrete import Action, DiscreteSpace, DiscreteState, Move
from ._semantics import SlicedSemantics
from ._symbolic import Form, InvariantGuardedSpace, PlannedMove, StateRecord, SymbolicSpace
