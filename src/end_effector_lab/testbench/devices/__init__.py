"""Devices as their makers' manuals describe them: registers and behaviour, and nothing of a tool's description.

`model_for` returns the model of a device by its name in a library of devices. A device without a model is played from
its description.
"""

from ._frames import (
    ILLEGAL_VALUE,
    LONGEST,
    FrameReader,
    RegisterRequest,
    crc16,
    done_answer,
    exception_answer,
    read_request,
    sealed,
)
from ._onrobot import OnRobotRG2, OnRobotVG10
from ._remote_io import Adam4056, RemoteIo, Wago750
from ._robotiq import Robotiq2F85, Robotiq2F140, RobotiqHandE
from ._robotiq_epick import RobotiqEPick
from ._schunk_egu import SchunkEgu
from ._unit import UnitModel

MODELS: dict[str, type[UnitModel]] = {
    model.name: model
    for model in (
        Robotiq2F85,
        Robotiq2F140,
        RobotiqHandE,
        RobotiqEPick,
        SchunkEgu,
        OnRobotRG2,
        OnRobotVG10,
        RemoteIo,
        Wago750,
        Adam4056,
    )
}
_BOARDS = ("lc-relay-8", "waveshare-io-8", "waveshare-relay-8")
"""I/O boards of the library whose outputs and inputs are coils and discrete inputs, as the standard has them."""


def model_for(name: str) -> type[UnitModel] | None:
    """Return the model of a device by its name in a library of devices; None: there is none."""
    return MODELS.get(RemoteIo.name if name in _BOARDS else name)
