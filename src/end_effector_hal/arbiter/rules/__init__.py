"""The rules of the lines: leases, interlocks, last wills. No sockets and no files; time is an argument, in µs."""

from ._arbiter import LineArbiter
from ._coils import SecondCoil
from ._lines import DROP_FIRST, UNKNOWN_ROLES, left_behind
from ._policy import Exclusion, Need, Policy, Role
from ._predicates import CLOCKS, FORMER, SKEW_US
from ._sender_role import SecondSenderError, SenderRole
from ._session import (
    ArbiterState,
    Driven,
    DrivenLine,
    Session,
    process_words,
    read_arbiter_state,
    read_driven,
    read_faults,
    read_levels,
)
