"""Modbus RTU: a polled codec made of reads, and presets for devices whose registers are known."""

from ._codec import ModbusDevice, ModbusRtu
from ._master import ModbusMaster
from ._presets import EPick, OnRobotVG, Transmitters
from ._read import COILS, DISCRETE_INPUTS, HOLDING, INPUT, Read, Readout, Register

__all__ = [
    "COILS",
    "DISCRETE_INPUTS",
    "HOLDING",
    "INPUT",
    "EPick",
    "ModbusDevice",
    "ModbusMaster",
    "ModbusRtu",
    "OnRobotVG",
    "Read",
    "Readout",
    "Register",
    "Transmitters",
]
