"""Codecs of devices with known registers. They are only read: their actuators are switched by the lines."""

from __future__ import annotations

from end_effector_hal.codecs.modbus._codec import ModbusRtu
from end_effector_hal.codecs.modbus._read import INPUT, Read, Register


class EPick(ModbusRtu):
    """Robotiq EPick: 115200 8N1, unit 9; the pressure is in whole kPa, 100 is ambient (its manual, section 4)."""

    def __init__(self) -> None:
        vacuum = Register("vacuum", 1000.0, word=2, shift=8, bits=8, zero=100)
        read = Read(9, 0x07D0, (vacuum,), count=3, function=INPUT)
        super().__init__("modbus-rtu-epick", (read,), baudrate=115_200, period_us=20_000)


class OnRobotVG(ModbusRtu):
    """OnRobot VG10 and VGC10: 115200 8E1, unit 65; vacuum of both channels in 1/1000 of an atmosphere."""

    def __init__(self) -> None:
        channels = ("vacuum_a", "vacuum_b")
        registers = tuple(
            Register(name, -101.325, word=word, highest=1000) for word, name in enumerate(channels)
        )
        read = Read(65, 18, registers, count=2)
        super().__init__("modbus-rtu-onrobot-vg", (read,), baudrate=115_200, parity="E", period_us=50_000)


class Transmitters(ModbusRtu):
    """Four generic pressure transmitters on one bus: 9600 8N1, units 1 to 4, signed 0.1 kPa at 0x0016."""

    def __init__(self) -> None:
        channels = ("bottom", "cylinder", "top", "supply")
        reads = tuple(
            Read(unit, 0x0016, (Register(name, 100.0, signed=True, lowest=-1100, highest=20_000),))
            for unit, name in enumerate(channels, start=1)
        )
        super().__init__(
            "modbus-rtu-transmitters", reads, baudrate=9_600, period_us=200_000, timeout_us=60_000
        )
