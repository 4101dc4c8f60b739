"""The simulated world at the other end of the wires; replaces the paper's Raspberry Pi."""

from ._bench import Bench
from ._board_sensors import BoardSensors
from ._noise import Noise
from ._ports import Port, PtyPort, SerialPort
from ._possible import offered_faults, possible_faults
from ._scenario import FAULTS, TOOL_CHANGER, Effect, Fault, Scenario, parse_scenario, plain_number
from ._sensor_board import SensorBoard, Sent, carried
from ._testbench import Testbench, Watcher
from .modbus import CommandedRegisters
from .program import (
    Events,
    FaultServer,
    Record,
    edges_of,
    lines_of,
    open_inputs,
    open_ports,
    open_sensors,
    run_testbench,
    write_description,
    write_virtual_copy,
)

__all__ = [
    "FAULTS",
    "TOOL_CHANGER",
    "Bench",
    "BoardSensors",
    "CommandedRegisters",
    "Effect",
    "Events",
    "Fault",
    "FaultServer",
    "Noise",
    "Port",
    "PtyPort",
    "Record",
    "Scenario",
    "SensorBoard",
    "Sent",
    "SerialPort",
    "Testbench",
    "Watcher",
    "carried",
    "edges_of",
    "lines_of",
    "offered_faults",
    "open_inputs",
    "open_ports",
    "open_sensors",
    "parse_scenario",
    "plain_number",
    "possible_faults",
    "run_testbench",
    "write_description",
    "write_virtual_copy",
]
