"""Where the testbench sees the lines: a virtual chip, real lines, simulated and emulated ones.

Inputs of your own are a class with the methods of `LineInputs`, and a test that inherits `LineInputsConformance` of
``conformance``.
"""

from ._gpio import GpioInputs
from ._gpio_sim import GpioSimInputs
from ._inputs import Clock, LineInputs, Monotonic, clock_of
from ._qemu import QemuInputs
from ._virtual import VirtualInputs
from .virtio_gpio import VirtioGpioInputs
