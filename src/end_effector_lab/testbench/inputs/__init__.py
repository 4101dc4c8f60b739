"""Where the testbench sees the lines: on a virtual chip, on real lines, or on those that the kernel simulates.

Inputs of your own are a class with the methods of `LineInputs`, and a test that inherits `LineInputsConformance` of
``conformance``.
"""

from ._gpio import GpioInputs
from ._gpio_sim import GpioSimInputs
from ._inputs import Clock, LineInputs, Monotonic, OnEdge, clock_of
from ._virtual import VirtualInputs
