"""Sources of line levels for the testbench: a virtual chip, real lines, or lines that the kernel simulates.

Your own inputs are a class with the methods of `LineInputs`, and a test that inherits `LineInputsConformance` of
``conformance``.
"""

from ._gpio import GpioInputs
from ._gpio_sim import GpioSimInputs
from ._inputs import Clock, LineInputs, Monotonic, OnEdge, clock_of
from ._virtual import VirtualInputs
