"""The rules of the lines: leases, interlocks, last wills. No sockets, no files; time is an argument, in µs."""

from ._arbiter import LineArbiter
from ._coils import SecondCoil
from ._policy import Exclusion, Need, Policy
from ._sender_role import SecondSenderError, SenderRole
from ._session import ArbiterState, Session, process_words, read_arbiter_state, read_faults, read_levels
