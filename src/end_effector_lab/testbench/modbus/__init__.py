"""The device at the far end of a bus, with the registers that a description commands; works for any tool."""

from ._commanded import CommandedRegisters
from ._rtu import LONGEST, RegisterRequest, done_answer, exception_answer, read_request, sealed
