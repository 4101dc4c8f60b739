"""OnRobot's VG10, an electric vacuum gripper with two groups of cups.

Sources: OnRobot, VG10 user manual 1.1.1, pages 17 to 19; public drivers for the registers from 20 on, the highest power
limit, and that a target above 80 % is accepted. Assumed, as no source says it: that a mode other than 0 to 2 is
refused, and that without power both groups are vented.
"""

from __future__ import annotations

from collections.abc import Mapping

from end_effector_lab.testbench.physics import Device, VacuumCircuit

from ._unit import BadValueError, NoSuchRegisterError, Tell, UnitModel

RELEASE, GRIP, IDLE = range(3)
"""Modes, in the high byte of a control register; the low byte is the target in percent."""
POWER_LIMIT, LIMIT_MA, MOST_MA = 2, 500, 1000
STATUS, STATUS_SIZE = 18, 7
"""Vacuum of both channels in 1/1000, current, two that are not described, temperature, speed of the pump."""
MOST_PERCENT = 80
ATMOSPHERE_KPA = 101.325


class OnRobotVG10(UnitModel):
    """A VG10: control of channel A and B in the registers 0 and 1, vacuum in 18 and 19."""

    name = "onrobot-vg10"
    functions = frozenset({3, 6, 16})
    physics = VacuumCircuit

    def __init__(self, devices: Mapping[int, Device], tell: Tell) -> None:
        super().__init__(devices, tell)
        self._written = [0, 0, LIMIT_MA]

    @staticmethod
    def channel_of(address: int) -> int:
        return address

    def power_up(self, at: int) -> None:
        self._written = [0, 0, LIMIT_MA]
        for channel in self.devices:
            self._tell(channel, False)

    def read(self, function: int, address: int, size: int, at: int) -> tuple[int, ...]:
        if address + size <= len(self._written):
            return tuple(self._written[address : address + size])
        first = address - STATUS
        if first < 0 or first + size > STATUS_SIZE:
            raise NoSuchRegisterError
        shown = [self._reading(0), self._reading(1), *[0] * (STATUS_SIZE - 2)]
        return tuple(shown[first : first + size])

    def write(self, address: int, values: tuple[int, ...], at: int, *, coils: bool) -> None:
        written = dict(enumerate(values, start=address))
        if coils or max(written) >= len(self._written):
            raise NoSuchRegisterError
        if any(value > MOST_MA if at == POWER_LIMIT else value >> 8 > IDLE for at, value in written.items()):
            raise BadValueError
        for register, value in written.items():
            self._written[register] = value
            if register in self.devices and value >> 8 != IDLE:  # an idle pump vents nothing
                self._tell(register, value >> 8 == GRIP and value & 0xFF > 0)

    def _reading(self, channel: int) -> int:
        """Vacuum of a channel in 1/1000; the pump stops at its target."""
        if channel not in self.devices:
            return 0
        found = max(round(-1000 * (self.devices[channel].pressure_kpa or 0.0) / ATMOSPHERE_KPA), 0)
        mode, percent = divmod(self._written[channel], 256)
        return min(found, 10 * min(percent, MOST_PERCENT)) if mode == GRIP else found
