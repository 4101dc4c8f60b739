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
from ._models import MODELS, model_for
from ._remote_io import RemoteIo
from ._unit import UnitModel
