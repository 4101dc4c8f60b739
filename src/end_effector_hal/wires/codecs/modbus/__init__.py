"""Modbus RTU: a polled codec made of reads, and presets for devices whose registers are known."""

from end_effector_hal.wires.codecs.modbus._codec import ModbusRtu
from end_effector_hal.wires.codecs.modbus._presets import EPick, OnRobotVG, Transmitters
from end_effector_hal.wires.codecs.modbus._read import HOLDING, INPUT, Read, Register

__all__ = ["HOLDING", "INPUT", "EPick", "ModbusRtu", "OnRobotVG", "Read", "Register", "Transmitters"]
