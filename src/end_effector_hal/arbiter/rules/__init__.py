"""The rules of the lines: leases, interlocks, last wills. No sockets, no files; time is an argument, in µs."""

from ._arbiter import Keeper
from ._policy import Exclusion, Need, Policy
from ._sender_role import Prover, SecondProverError
from ._session import Session, WillRunsError, process_words
from ._state import Bequest, Memory, read_faults, read_memory

__all__ = [
    "Bequest",
    "Exclusion",
    "Keeper",
    "Memory",
    "Need",
    "Policy",
    "Prover",
    "SecondProverError",
    "Session",
    "WillRunsError",
    "process_words",
    "read_faults",
    "read_memory",
]
