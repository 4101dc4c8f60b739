"""Robotiq's units: six bytes in each direction, an activation, faults, a watchdog; and the grippers with two fingers.

Sources: Robotiq, 2F-85 and 2F-140 instruction manual (2019), its chapter on control and examples of Modbus RTU; Hand-E
instruction manual, section 4; the end positions 3 and 230 are those of public drivers. Assumed, as no source says it:
the speed of an activation and of an automatic release, the current while it moves, that only the first answer after a
silence shows fault 9, and that fingers without power stay where they are.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import ClassVar

from end_effector_lab.testbench.physics import Device, Fingers, Leg

from ._unit import NoSuchRegisterError, Tell, UnitModel, fingers_of

OUTPUTS, INPUTS = 0x03E8, 0x07D0
SIZE = 3
"""Registers in each direction; those after them are reserved."""
RESET, ACTIVATING, ACTIVE = 0, 1, 3
"""Values of gSTA."""
ACT, GTO, ATR = 0x01, 0x08, 0x10
"""Bits of the action request: activate, go to the requested position or vacuum, automatic release."""
TOO_EARLY, NOT_ACTIVATED, IDLE, RELEASING, RELEASED = 0x5, 0x7, 0x9, 0xB, 0xF
"""Fault codes: a command during the activation, and before it; no message; automatic release running, and over."""
MAJOR = range(0xA, 0x10)
"""Fault codes that only a new activation clears."""


class RobotiqUnit(UnitModel):
    """Registers and activation of a unit of Robotiq's: 0x03E8 to 0x03EA are written, 0x07D0 to 0x07D2 read.

    The rising edge of rACT begins an activation, whatever else is in the request; rACT 0 resets the unit and clears
    its faults. A command before the activation gives fault 7. A command during it gives fault 5, and is executed
    afterwards. The automatic release overrides everything but rACT; after it only a new activation helps.

    Function 6 is said by a driver, not by the manuals that were read; the outputs cannot be read.
    """

    functions = frozenset({3, 4, 6, 16, 23})
    silence_us: ClassVar[int] = 1_000_000
    """Time without a message after which it shows fault 9, µs."""

    def __init__(self, devices: Mapping[int, Device], tell: Tell) -> None:
        super().__init__(devices, tell)
        self.command = [0] * 2 * SIZE
        """The six bytes that were written."""
        self.state = RESET
        self.fault = 0
        self.is_late = False
        """Whether no message came for too long before the last one."""
        self._heard_at = self._now = 0

    def power_up(self, at: int) -> None:
        self.command = [0] * 2 * SIZE
        self.state, self.fault, self._heard_at = RESET, 0, at
        self.stop()

    def hear(self, at: int) -> None:
        self._now = at
        self.is_late = at - self._heard_at > self.silence_us
        self._heard_at = at

    def wants(self, bit: int) -> bool:
        """Return whether a bit of the action request is set."""
        return bool(self.command[0] & bit)

    def read(self, function: int, address: int, size: int, at: int) -> tuple[int, ...]:
        first = address - INPUTS
        if function not in (3, 4) or first < 0 or first + size > SIZE:
            raise NoSuchRegisterError
        bytes_ = self.status()
        bytes_[0] |= self.state << 4 | self.wants(ACT)
        bytes_[2], bytes_[3] = self._shown_fault(), self.command[3]
        return tuple(bytes_[2 * i] << 8 | bytes_[2 * i + 1] for i in range(first, first + size))

    def write(self, address: int, values: tuple[int, ...], at: int, *, coils: bool) -> None:
        first = address - OUTPUTS
        if coils or first < 0 or first + len(values) > SIZE:
            raise NoSuchRegisterError
        was_active = self.wants(ACT)
        for index, value in enumerate(values, start=first):
            self.command[2 * index : 2 * index + 2] = divmod(value, 256)
        if not self.wants(ACT):
            self.state = RESET
            self.fault = 0
            self.stop()
        elif not was_active:
            self.state, self.fault = ACTIVATING, 0
            self.activate(at)
        elif self.wants(ATR) and self.state == ACTIVE:
            self.state, self.fault = RESET, RELEASING
            self.release()
        elif self.state == ACTIVE:
            self.obey(at)

    def advance(self, at: int) -> None:
        self._now = at
        if self.alarm in MAJOR:
            self.fault = self.alarm
        if not self.has_finished(at):
            return
        if self.state == ACTIVATING:
            self.state = ACTIVE
            if self.wants(ATR):
                self.state, self.fault = RESET, RELEASING
                self.release()
            elif self.wants(GTO):
                self.obey(at)
        elif self.fault == RELEASING:
            self.fault = RELEASED

    def _shown_fault(self) -> int:
        if self.alarm or self.fault:
            return self.alarm or self.fault
        if self.wants(GTO) and self.state != ACTIVE:
            return TOO_EARLY if self.state == ACTIVATING else NOT_ACTIVATED
        return IDLE if self.is_late else 0

    @abstractmethod
    def status(self) -> list[int]:
        """Return the six bytes of the status, without those that all units have: gACT, gSTA, gFLT and gPR."""

    @abstractmethod
    def stop(self) -> None:
        """Stop what is driven."""

    @abstractmethod
    def activate(self, at: int) -> None:
        """Begin the activation."""

    @abstractmethod
    def obey(self, at: int) -> None:
        """Execute the command that is in the registers; the unit is active."""

    @abstractmethod
    def release(self) -> None:
        """Begin the automatic release."""

    @abstractmethod
    def has_finished(self, at: int) -> bool:
        """Return whether what `activate` or `release` began is over."""


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
