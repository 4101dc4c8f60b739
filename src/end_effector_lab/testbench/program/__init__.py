"""The testbench program: runs from a command line to a signal, reads commands, and writes records."""

from ._fault_server import FaultServer
from ._places import lines_of, open_inputs, open_ports, open_sensors
from ._records import Events, Record, edges_of
from ._run import run_testbench
from ._virtual_copy import write_description, write_virtual_copy
