"""The simulated world on the other end of the wires: the paper's Raspberry Pi."""

from ._bench import Bench
from ._carried import carried
from ._clock import Clock, Monotonic, clock_of
from ._faults import FAULTS, Fault
from ._gpio_inputs import GpioInputs
from ._inputs import LineInputs, OnEdge, VirtualInputs
from ._noise import Noise
from ._parse import parse_scenario
from ._places import open_inputs, open_port
from ._ports import Port, PtyPort, SerialPort
from ._qemu_inputs import QemuInputs
from ._records import Events, Record, edges_of
from ._run import run_testbench
from ._scenario import Effect, Scenario
from ._sensor_board import SensorBoard, Sent
from ._sim_inputs import GpioSimInputs
from ._testbench import Testbench, Watcher

__all__ = [
    "FAULTS",
    "Bench",
    "Clock",
    "Effect",
    "Events",
    "Fault",
    "GpioInputs",
    "GpioSimInputs",
    "LineInputs",
    "Monotonic",
    "Noise",
    "OnEdge",
    "Port",
    "PtyPort",
    "QemuInputs",
    "Record",
    "Scenario",
    "SensorBoard",
    "Sent",
    "SerialPort",
    "Testbench",
    "VirtualInputs",
    "Watcher",
    "carried",
    "clock_of",
    "edges_of",
    "open_inputs",
    "open_port",
    "parse_scenario",
    "run_testbench",
]
