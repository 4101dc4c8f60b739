"""The faults of a simulated tool: what a testbench offers, and the messages with which a page chooses one."""

from ._protocol import (
    ALIVE_US,
    LONGEST,
    MOST_TEXT,
    NOMINAL,
    VALID_US,
    FaultNumber,
    FaultOffer,
    FaultRequest,
    TestbenchHeader,
    TestbenchScenario,
    answer_line,
    message_line,
    read_fault_request,
    socket_of_testbench,
)
