"""The discrete and the symbolic states of a network; each state is computed once."""

from ._discrete import Action, DiscreteSpace, DiscreteState, Move
from ._semantics import SlicedSemantics
from ._symbolic import Form, InvariantGuardedSpace, PlannedMove, StateRecord, SymbolicSpace
