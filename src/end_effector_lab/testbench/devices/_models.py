"""The models by the names of their devices."""

from __future__ import annotations

from ._onrobot_vg import OnRobotVG10
from ._remote_io import RemoteIo
from ._robotiq_2f import Robotiq2F85, Robotiq2F140, RobotiqHandE
from ._robotiq_epick import RobotiqEPick
from ._unit import UnitModel

MODELS: dict[str, type[UnitModel]] = {
    model.name: model
    for model in (Robotiq2F85, Robotiq2F140, RobotiqHandE, RobotiqEPick, OnRobotVG10, RemoteIo)
}
_PARTS = {"onrobot-vg10-a": OnRobotVG10.name, "onrobot-vg10-b": OnRobotVG10.name}
"""Devices that a library describes in parts, and the models of the whole."""


def model_for(name: str) -> type[UnitModel] | None:
    """Return the model of a device by its name in a library of devices; None: there is none."""
    return MODELS.get(_PARTS.get(name, name))
