"""Physics of the devices: effects of the lines on real states and sensors, on a grid of one millisecond.

The physics of your own kind needs three parts: a subclass of `Device`, which advances in steps, or of `SolvedDevice`,
which is computed from one switching to the next and is much faster; an entry point in the group
``end_effector_hal.physics`` under the name of the kind; and a test that inherits `PhysicsConformance` of its
``conformance``.
"""

from ._cylinder import Cylinder, ToolChanger
from ._device import (
    ACTUATOR,
    CHANGER,
    LEAKS,
    PARTS,
    PRESSURE,
    STICKS,
    Device,
    Plant,
    SolvedDevice,
    physics_of,
)
from ._grippers import Fingers, HoldingMagnet, Leg
from ._parts import STEP_S, STEP_US, Course, Model, Sensor, SolvedModel, Supply, Valve
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
    "Leg",
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
