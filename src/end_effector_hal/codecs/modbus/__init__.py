"""Modbus RTU: a polled codec made of reads, and presets for devices whose registers are known."""

from ._adu import acknowledgement, write_request
from ._codec import EPick, ModbusDevice, ModbusRtu, OnRobotVG, Transmitters
from ._master import ModbusMaster, exception_words
from ._read import COILS, DISCRETE_INPUTS, HOLDING, INPUT, Read, Readout, Register, RegisterWrite
from ._relay import BusCodec, RelayedBus, cycle_record

__all__ = [
    "COILS",
    "DISCRETE_INPUTS",
    "HOLDING",
    "INPUT",
    "BusCodec",
    "EPick",
    "ModbusDevice",
    "ModbusMaster",
    "ModbusRtu",
    "OnRobotVG",
    "Read",
    "Readout",
    "Register",
    "RegisterWrite",
    "RelayedBus",
    "Transmitters",
    "acknowledgement",
    "cycle_record",
    "exception_words",
    "write_request",
]
