"""Executes some processes of a network; its inputs are events and time, its outputs are steps and a deadline."""

from ._boundary import ExecutionBoundary
from ._execution import Execution, Foresight
from ._live import live
from ._observations import (
    Begun,
    Event,
    ExecutionSnapshot,
    Observation,
    Reaction,
    Received,
    Resumed,
    Step,
    TakenEdge,
    Written,
    resume,
    snapshot_of,
)
from ._successors import NEVER, ClockInstants, SuccessorCache

__all__ = [
    "NEVER",
    "Begun",
    "ClockInstants",
    "Event",
    "Execution",
    "ExecutionBoundary",
    "ExecutionSnapshot",
    "Foresight",
    "Observation",
    "Reaction",
    "Received",
    "Resumed",
    "Step",
    "SuccessorCache",
    "TakenEdge",
    "Written",
    "live",
    "resume",
    "snapshot_of",
]
