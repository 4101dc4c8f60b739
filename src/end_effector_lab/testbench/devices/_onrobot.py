"""OnRobot's RG2, an electric gripper with two fingers, and VG10, an electric vacuum gripper with two groups of cups.

Sources for the RG2: takuya-ki/onrobot-rg (src/onrobot.py: registers, units, bits of the status, that a command while it
is busy is ignored); a public driver for ROS 2 with the same addresses. Assumed, as no source says it: the speed, that a
force or a width beyond its range is refused, and that fingers without power stay where they are.

Sources for the VG10: OnRobot, VG10 user manual 1.1.1, pages 17 to 19; public drivers for the registers from 20 on, the
highest power limit, and that a target above 80 % is accepted. Assumed, as no source says it: that a mode other than 0
to 2 is refused, and that without power both groups are vented.
"""

from __future__ import annotations

from collections.abc import Mapping

from end_effector_lab.testbench.physics import Device, Fingers, Leg, VacuumCircuit

from ._unit import BadValueError, NoSuchRegisterError, Tell, UnitModel, fingers_of

MOST = 400, 1100, 16
"""Largest force, 1/10 N; width, 1/10 mm; and command, in the registers 0 to 2."""
MOVE, STOP, MOVE_WITH_OFFSET = 1, 8, 16
WIDTH, STATUS = 0x010B, 0x010C
BUSY, GRIPPED, SAFETY = 1 << 0, 1 << 1, 1 << 3
"""Bits of the status; once SAFETY is set, it moves only after its power was off."""
SPEED = 1.0
"""Strokes per second."""


class OnRobotRG2(UnitModel):
    """An RG2: force, width and command in the registers 0 to 2, width and status in 0x010B and 0x010C."""

    name = "onrobot-rg2"
    functions = frozenset({3, 6, 16})
    physics = Fingers

    def __init__(self, devices: Mapping[int, Device], tell: Tell) -> None:
        super().__init__(devices, tell)
        self._fingers = fingers_of(devices)
        self._written, self._safety = [0, 0, 0], 0

    def power_up(self, at: int) -> None:
        self._written, self._safety = [0, 0, 0], 0
        self._fingers.stop()

    def read(self, function: int, address: int, size: int, at: int) -> tuple[int, ...]:
        status = self._safety | BUSY * self._fingers.moves
        status |= GRIPPED * (self._fingers.closes and not self._fingers.moves and self._fingers.bits["part"])
        shown = dict(enumerate(self._written))
        shown |= {WIDTH: round((1.0 - self._fingers.position) * MOST[1]), STATUS: status}
        if not shown.keys() >= set(range(address, address + size)):
            raise NoSuchRegisterError
        return tuple(shown[each] for each in range(address, address + size))

    def write(self, address: int, values: tuple[int, ...], at: int, *, coils: bool) -> None:
        last = address + len(values)
        if coils or last > len(self._written):
            raise NoSuchRegisterError
        if any(value > most for value, most in zip(values, MOST[address:last], strict=True)):
            raise BadValueError
        self._written[address:last] = values
        command = self._written[2] if last > 2 else 0
        if command == STOP:
            self._fingers.stop()
        elif command in (MOVE, MOVE_WITH_OFFSET) and not self._safety and not self._fingers.moves:
            to = 1.0 - self._written[1] / MOST[1]
            closes = to > self._fingers.position
            self._fingers.drive(Leg(to, SPEED), closes=closes)
            self._tell(0, closes)

    def advance(self, at: int) -> None:
        if self.alarm and not self._safety:
            self._safety = SAFETY
            self._fingers.stop()

    def settle(self) -> None:
        self._fingers.settle(self._fingers.closes)


RELEASE, GRIP, IDLE = range(3)
"""Modes, in the high byte of a control register; the low byte is the target in percent."""
POWER_LIMIT, LIMIT_MA, MOST_MA = 2, 500, 1000
SHOWN, SHOWN_SIZE = 18, 7
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
        first = address - SHOWN
        if first < 0 or first + size > SHOWN_SIZE:
            raise NoSuchRegisterError
        shown = [self._reading(0), self._reading(1), *[0] * (SHOWN_SIZE - 2)]
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
