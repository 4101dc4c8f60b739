"""Compares two networks: whether one does only what the other may do, and whether an edit changes what can happen."""

from ._equivalence import ReachedNetwork
from ._inclusion import Inclusion, trace_inclusion
from ._interface import Interface
from ._run import ComparedStep

__all__ = ["ComparedStep", "Inclusion", "Interface", "ReachedNetwork", "trace_inclusion"]
