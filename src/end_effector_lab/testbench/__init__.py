"""The simulated world at the other end of the wires; replaces the paper's Raspberry Pi."""

from ._bench import Bench
from ._faults import offered_faults, possible_faults
from ._modbus import CommandedRegisters
from ._places import lines_of, open_inputs, open_ports, open_sensors, write_description, write_virtual_copy
from ._ports import Port
from ._program import edges_of, run_testbench
from ._scenario import FAULTS, TOOL_CHANGER, Fault, Scenario, parse_scenario, plain_number
from ._sensor_board import BoardSensors, SensorBoard, Sent, carried
from ._testbench import Testbench
from ._units import Models, chosen_models, text_of

__all__ = [
    "FAULTS",
    "TOOL_CHANGER",
    "Bench",
    "BoardSensors",
    "CommandedRegisters",
    "Fault",
    "Models",
    "Port",
    "Scenario",
    "SensorBoard",
    "Sent",
    "Testbench",
    "carried",
    "chosen_models",
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
    "text_of",
    "write_description",
    "write_virtual_copy",
]
