"""Modbus devices at the far end of a bus: three by their registers, and any that a description commands."""

from ._commanded import CommandedRegisters
from ._handshake import HandshakeGripper
from ._robotiq import Gripper2F85, SimulatedEPick
from ._rtu import RegisterMap, RtuServer
