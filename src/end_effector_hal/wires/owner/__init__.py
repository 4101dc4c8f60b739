"""The line owner: one process that owns all output lines, enforces their interlocks, and executes wills.

`serve` is that process, `OwnerClient` is for those who write lines. It knows no gripping logic, no GPIO and
no ROS: a back-end and a `Policy` are given to it.
"""

from end_effector_hal.wires.owner._client import OwnerClient, Written
from end_effector_hal.wires.owner._keeper import Keeper
from end_effector_hal.wires.owner._policy import Exclusion, Need, Policy
from end_effector_hal.wires.owner._serve import serve
from end_effector_hal.wires.owner._server import LineOwner
from end_effector_hal.wires.owner._teller import Teller
from end_effector_hal.wires.will import Will, WillStep

__all__ = [
    "Exclusion",
    "Keeper",
    "LineOwner",
    "Need",
    "OwnerClient",
    "Policy",
    "Teller",
    "Will",
    "WillStep",
    "Written",
    "serve",
]
