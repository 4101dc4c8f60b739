"""Modbus RTU: a polled codec made of reads, and presets for devices whose registers are known."""

from ._codec import ModbusRtu
from ._presets import EPick, OnRobotVG, Transmitters
from ._read import HOLDING, INPUT, Read, Register

__all__ = ["HOLDING", "INPUT", "EPick", "ModbusRtu", "OnRobotVG", "Read", "Register", "Transmitters"]
