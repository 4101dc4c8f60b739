"""SCHUNK's EGU and EGK, electric grippers with parallel jaws, on Modbus RTU.

Sources: SCHUNK-SE-Co-KG/schunk_egu_egk_gripper, the maker's own driver (registers, bits, units) and its simulated
gripper (what a command does, and in an error). Assumed, as no source says it: that a command begins where its bit
rises, that a release opens fully, the speed and the stroke, that a lost workpiece is no error, and that jaws without
power stay where they are.
"""

from __future__ import annotations

from collections.abc import Mapping

from end_effector_lab.testbench.physics import Device, Fingers, Leg

from ._unit import NoSuchRegisterError, Tell, UnitModel, fingers_of

STATUS, CONTROL, SIZE = 0x003F, 0x0047, 8
"""First registers of the 16 bytes in each direction; byte 0 is the high byte of the first one, bit 0 its lowest bit."""
RELEASE, GRIP, ABSOLUTE = 1 << 11, 1 << 12, 1 << 13
MOVES_ON, STOP, ACKNOWLEDGE = 1 << 0, 1 << 1, 1 << 2
"""Bits of the control double word; without MOVES_ON it makes a fast stop, which is an error."""
READY, SUCCESS, RECEIVED, ERROR = 1 << 0, 1 << 4, 1 << 5, 1 << 7
NO_WORKPIECE, GRIPPED, REACHED, LOST = 1 << 11, 1 << 12, 1 << 13, 1 << 16
"""Bits of the status double word."""
FAST_STOP = 0xD9
STROKE_UM, SPEED = 40_000, 1.5
"""Position of open jaws, µm, and usual speed in strokes per second."""


class SchunkEgu(UnitModel):
    """An EGU or EGK: status in 0x003F to 0x0046, control in 0x0047 to 0x004E, both with function 3, written with 16.

    It powers up in the error of a fast stop, and obeys nothing until that is acknowledged.
    """

    name = "schunk-egu"
    functions = frozenset({3, 16})
    physics = Fingers

    def __init__(self, devices: Mapping[int, Device], tell: Tell) -> None:
        super().__init__(devices, tell)
        self._fingers = fingers_of(devices)
        self._written = bytearray(2 * SIZE)
        self._error, self._shown, self._command = FAST_STOP, 0, 0

    def power_up(self, at: int) -> None:
        self._written = bytearray(2 * SIZE)
        self._shown = 0
        self._fail(FAST_STOP)

    def read(self, function: int, address: int, size: int, at: int) -> tuple[int, ...]:
        error = self.alarm or self._error
        bits = self._shown | (ERROR if error else READY)
        position = round((1.0 - self._fingers.position) * STROKE_UM)
        status = (
            bits.to_bytes(4, "little") + position.to_bytes(4, "little") + bytes(4) + bytes([error, 0, 0, 0])
        )
        both, first = status + self._written, address - STATUS
        if first < 0 or first + size > 2 * SIZE:
            raise NoSuchRegisterError
        return tuple(both[2 * i] << 8 | both[2 * i + 1] for i in range(first, first + size))

    def write(self, address: int, values: tuple[int, ...], at: int, *, coils: bool) -> None:
        first = address - CONTROL
        if coils or first < 0 or first + len(values) > SIZE:
            raise NoSuchRegisterError
        before = self._control
        for index, value in enumerate(values, start=first):
            self._written[2 * index : 2 * index + 2] = value.to_bytes(2, "big")
        risen = self._control & ~before
        if not self._control & MOVES_ON:
            self._fail(FAST_STOP)
        elif risen & ACKNOWLEDGE:
            self._error = 0
        elif not self._error and risen & (STOP | RELEASE | GRIP | ABSOLUTE):
            self._obey(risen)

    def advance(self, at: int) -> None:
        if self._shown & GRIPPED and not self._fingers.bits["part"]:
            self._shown = self._shown & ~(GRIPPED | SUCCESS) | LOST
        if not self._command or self._fingers.moves:
            return
        if self._command != GRIP:
            done = self._fingers.position == self._target
            self._shown |= SUCCESS | REACHED if done else 0
        elif self._fingers.bits["part"]:
            self._shown |= SUCCESS | GRIPPED
        elif self._fingers.bits["closed"]:
            self._shown |= NO_WORKPIECE
        else:
            return
        self._command = 0

    def settle(self) -> None:
        self._fingers.settle(self._fingers.closes)
        self.advance(0)

    @property
    def _control(self) -> int:
        return int.from_bytes(self._written[:4], "little")

    @property
    def _target(self) -> float:
        if self._command == RELEASE:
            return 0.0
        if self._command == GRIP:
            return 1.0
        position = int.from_bytes(self._written[4:8], "little", signed=True)
        return min(max(1.0 - position / STROKE_UM, 0.0), 1.0)

    def _fail(self, error: int) -> None:
        self._error, self._command = error, 0
        self._fingers.stop()

    def _obey(self, risen: int) -> None:
        self._shown = self._shown & RECEIVED ^ RECEIVED
        if risen & STOP:
            self._command = 0
            self._shown |= SUCCESS | REACHED
            self._fingers.stop()
            return
        self._command = next(each for each in (RELEASE, GRIP, ABSOLUTE) if risen & each)
        closes = self._target > self._fingers.position
        self._fingers.drive(Leg(self._target, SPEED), closes=closes)
        self._tell(0, closes)
