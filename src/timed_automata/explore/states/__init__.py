"""The discrete and the symbolic states of a network; each state is computed once."""

from ._discrete import DiscreteSpace, DiscreteState, Move
from ._symbolic import StateRecord, SymbolicSpace
