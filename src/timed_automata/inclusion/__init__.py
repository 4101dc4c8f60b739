"""Checks whether one network does only what another one allows: timed trace inclusion."""

from ._inclusion import Inclusion, trace_inclusion
from ._interface import Interface
from ._run import ComparedStep

__all__ = ["ComparedStep", "Inclusion", "Interface", "trace_inclusion"]
