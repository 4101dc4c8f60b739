"""Sources of line levels for the testbench: a virtual chip, real lines, or lines that the kernel simulates.

Your own inputs are a class with the methods of `LineInputs`.
"""

from ._gpio import GpioInputs, GpioSimInputs
from ._virtual import Clock, LineInputs, Monotonic, OnEdge, VirtualInputs, clock_of
