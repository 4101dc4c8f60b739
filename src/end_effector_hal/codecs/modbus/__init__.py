"""Modbus RTU: a polled codec made of reads, and presets for devices whose registers are known."""

from ._adu import acknowledgement, write_request
from ._codec import EPick, ModbusRtu, OnRobotVG, Transmitters
from ._master import ModbusMaster, exception_words
from ._read import Read, Register, RegisterWrite
from ._relay import BusCodec, RelayedBus, cycle_record
from ._tcp import TcpFrames

__all__ = [
    "BusCodec",
    "EPick",
    "ModbusMaster",
    "ModbusRtu",
    "OnRobotVG",
    "Read",
    "Register",
    "RegisterWrite",
    "RelayedBus",
    "TcpFrames",
    "Transmitters",
    "acknowledgement",
    "cycle_record",
    "exception_words",
    "write_request",
]
