"""The registers that a description commands, at the far end of a bus: as the device of any tool has them."""

from ._commanded import CommandedRegisters
from ._rtu import LONGEST, RegisterRequest, done_answer, exception_answer, read_request, sealed
