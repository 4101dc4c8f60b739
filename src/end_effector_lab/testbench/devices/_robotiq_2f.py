"""Robotiq's grippers with two fingers: 2F-85, 2F-140 and Hand-E.

Sources: Robotiq, 2F-85 and 2F-140 instruction manual (2019), its chapter on control and examples of Modbus RTU; Hand-E
instruction manual, section 4; the end positions 3 and 230 are those of public drivers. Assumed, as no source says it:
the speed of an activation and of an automatic release, the current while it moves, that only the first answer after a
silence shows fault 9, and that fingers without power stay where they are.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from end_effector_lab.testbench.physics import Device, Fingers, Leg

from ._robotiq import ACTIVE, GTO, RobotiqUnit
from ._unit import Tell, fingers_of

OPENED, CLOSED = 3, 230
"""gPO of fingers that are fully open, and that meet."""
MOVING, WHILE_OPENING, WHILE_CLOSING, AT_POSITION = range(4)
"""Values of gOBJ."""
MOVING_CURRENT = 10
"""gCU while it moves, in 10 mA."""
RELEASE_OPENS = 0x20
"""rARD: the automatic release opens the fingers; else it closes them."""


class Robotiq2F85(RobotiqUnit):
    """A 2F-85: rPR 0 is open and 255 closed, at a speed from 20 to 150 mm/s."""

    name = "robotiq-2f85"
    physics = Fingers
    stroke_mm: ClassVar[float] = 85.0
    speed_mm_s: ClassVar[tuple[float, float]] = (20.0, 150.0)

    def __init__(self, devices: Mapping[int, Device], tell: Tell) -> None:
        super().__init__(devices, tell)
        self._fingers = fingers_of(devices)
        self.stop()

    def status(self) -> list[int]:
        goes = self.wants(GTO) and self.state == ACTIVE
        moves = self._fingers.moves
        position = round(OPENED + self._fingers.position * (CLOSED - OPENED))
        return [goes << 3 | (self._object() << 6 if goes else 0), 0, 0, 0, position, MOVING_CURRENT * moves]

    def stop(self) -> None:
        self._fingers.stop()

    def activate(self, at: int) -> None:
        speed = self._speed(128)
        self._drive(Leg(1.0, speed), Leg(0.0, speed), closes=False)

    def obey(self, at: int) -> None:
        if not self.wants(GTO):
            self.stop()
            return
        to = self._target
        closes = to == 1.0 or (to > 0.0 and (to > self._fingers.position or self._fingers.closes))
        if to < self._fingers.position:
            closes = False
        self._drive(Leg(to, self._speed(self.command[4])), closes=closes)

    def release(self) -> None:
        opens = self.wants(RELEASE_OPENS)
        self._drive(Leg(0.0 if opens else 1.0, self._speed(0)), closes=not opens)

    def has_finished(self, at: int) -> bool:
        return not self._fingers.moves

    def settle(self) -> None:
        for _ in range(2):  # the activation, and what was commanded meanwhile
            self._fingers.settle(self._fingers.closes)
            self.advance(self._now)

    @property
    def _target(self) -> float:
        return min(max((self.command[3] - OPENED) / (CLOSED - OPENED), 0.0), 1.0)

    def _speed(self, value: int) -> float:
        """Return a speed of rSP in strokes per second."""
        slow, fast = self.speed_mm_s
        return (slow + (fast - slow) * value / 255) / self.stroke_mm

    def _object(self) -> int:
        if self._fingers.moves:
            return MOVING
        if self._fingers.position == self._target:
            return AT_POSITION
        return WHILE_CLOSING if self._fingers.position < self._target else WHILE_OPENING

    def _drive(self, *legs: Leg, closes: bool) -> None:
        self._fingers.drive(*legs, closes=closes)
        self._tell(0, closes)


class Robotiq2F140(Robotiq2F85):
    """A 2F-140: a stroke of 140 mm, at a speed from 30 to 250 mm/s."""

    name = "robotiq-2f140"
    stroke_mm = 140.0
    speed_mm_s = (30.0, 250.0)


class RobotiqHandE(Robotiq2F85):
    """A Hand-E: a stroke of 50 mm, at a speed from 20 to 150 mm/s."""

    name = "robotiq-hand-e"
    stroke_mm = 50.0
