"""The physics of actuator kinds by name: our own, and those that other distributions add by an entry point."""

from __future__ import annotations

from typing import Any

from end_effector_hal.errors import UsageError
from end_effector_hal.plugins import Plugins

from ._device import Device

GROUP = "end_effector_hal.physics"
OWN = {
    "vacuum": "end_effector_lab.testbench.physics:VacuumCircuit",
    "cylinder": "end_effector_lab.testbench.physics:Cylinder",
    "gripper": "end_effector_lab.testbench.physics:Fingers",
    "magnet": "end_effector_lab.testbench.physics:HoldingMagnet",
}


def physics_of(kind: str) -> type[Device]:
    """Return the physics of a kind of actuator.

    Raises:
        UsageError: the kind has no physics (the message lists those that have), or it cannot be loaded.
    """
    return _PHYSICS.get(kind)


def _checked(physics: Any) -> type[Device]:
    if not (isinstance(physics, type) and issubclass(physics, Device)):
        raise UsageError("this is no subclass of end_effector_lab.testbench.physics.Device.")
    return physics


_PHYSICS: Plugins[type[Device]] = Plugins(GROUP, "simulated kind of actuator", OWN, _checked, make=False)
