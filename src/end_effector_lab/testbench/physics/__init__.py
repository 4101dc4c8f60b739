"""How devices behave: what the lines switch, and what the sensors would show, on a grid of a millisecond.

The physics of a kind of your own is a subclass of `Device`, which goes in steps, or of `SolvedDevice`, which is solved
from one switching to the next and much quicker, an entry point in the group ``end_effector_hal.physics``
under the name of the kind, and a test that inherits `PhysicsConformance` of its ``conformance``.
"""

from ._course import Course
from ._cylinder import Cylinder
from ._device import ACTUATOR, CHANGER, LEAKS, PARTS, PRESSURE, STICKS, Device, Plant, SolvedDevice
from ._fingers import Fingers
from ._magnet import HoldingMagnet
from ._parts import STEP_S, STEP_US, Model, Sensor, SolvedModel, Supply, Valve
from ._registry import physics_of
from ._tool_changer import ToolChanger
from ._vacuum import VacuumCircuit

__all__ = [
    "ACTUATOR",
    "CHANGER",
    "LEAKS",
    "PARTS",
    "PRESSURE",
    "STEP_S",
    "STEP_US",
    "STICKS",
    "Course",
    "Cylinder",
    "Device",
    "Fingers",
    "HoldingMagnet",
    "Model",
    "Plant",
    "Sensor",
    "SolvedDevice",
    "SolvedModel",
    "Supply",
    "ToolChanger",
    "VacuumCircuit",
    "Valve",
    "physics_of",
]
