"""OnRobot's RG2, an electric gripper with two fingers.

Sources: takuya-ki/onrobot-rg (src/onrobot.py: registers, units, bits of the status, that a command while it is busy is
ignored); a public driver for ROS 2 with the same addresses. Assumed, as no source says it: the speed, that a force or a
width beyond its range is refused, and that fingers without power stay where they are.
"""

from __future__ import annotations

from collections.abc import Mapping

from end_effector_lab.testbench.physics import Device, Fingers, Leg

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
