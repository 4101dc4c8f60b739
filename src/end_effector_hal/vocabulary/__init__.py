"""The words that every room shares: Table II, evidence, causes, last wills, units; no logic."""

from ._last_will import LEASE_US, SETTLE_US, LastWill, LastWillStep, read_last_will
from ._levels import Cause, ChangerFault, ChangerState, Evidence, ToolEvidence
from ._limits import LONGEST_MESSAGE, MOST_ACTUATORS, MOST_CHANNELS, MOST_LINES, MOST_PREDICATES
from ._tables import (
    ACTIVE,
    INACTIVE,
    PENDING,
    ActuatorState,
    Command,
    EndEffectorState,
    TableState,
    display_name,
)
from ._text import (
    ARBITER_LOST,
    LONGEST_SENTENCE,
    OVER,
    STOPPED,
    escaped,
    hint,
    is_name,
    latched_il_13,
    latched_stop,
    printable,
)
from ._time import to_s, to_us

__all__ = [
    "ACTIVE",
    "ARBITER_LOST",
    "INACTIVE",
    "LEASE_US",
    "LONGEST_MESSAGE",
    "LONGEST_SENTENCE",
    "MOST_ACTUATORS",
    "MOST_CHANNELS",
    "MOST_LINES",
    "MOST_PREDICATES",
    "OVER",
    "PENDING",
    "SETTLE_US",
    "STOPPED",
    "ActuatorState",
    "Cause",
    "ChangerFault",
    "ChangerState",
    "Command",
    "EndEffectorState",
    "Evidence",
    "LastWill",
    "LastWillStep",
    "TableState",
    "ToolEvidence",
    "display_name",
    "escaped",
    "hint",
    "is_name",
    "latched_il_13",
    "latched_stop",
    "printable",
    "read_last_will",
    "to_s",
    "to_us",
]
