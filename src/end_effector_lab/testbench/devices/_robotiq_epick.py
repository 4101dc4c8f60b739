"""Robotiq's EPick, an electric vacuum generator.

Sources: PickNikRobotics/ros2_epick_gripper (epick_driver, registers and faults); ros-industrial-attic/robotiq, issue
164 (a release comes before the first grip). Assumed, as no source says it: the time of an activation and of an
automatic release; that fault 9 comes after 1.5 s, stops the pump and wants a new activation; that without regulation
and without power the cup is vented.
"""

from __future__ import annotations

from collections.abc import Mapping

from end_effector_lab.testbench.physics import Device, VacuumCircuit

from ._robotiq import ACTIVE, GTO, IDLE, RESET, RobotiqUnit
from ._unit import Tell

UNKNOWN, AT_MINIMUM, AT_MAXIMUM, NONE = range(4)
"""Values of gOBJ."""
STANDBY, GRIPPING, PASSIVE_RELEASE = range(3)
"""Values of gVAS."""
GRIP_TIMEOUT = 0x6
MODE = 0x06
"""Bits of rMOD; 0 is the automatic mode, which ignores minimum pressure and time-out."""
AMBIENT = 100
"""Pressure request and pressure at ambient pressure; less is vacuum, kPa."""
AUTOMATIC_MINIMUM, LONGEST = 90, 255
ACTIVATION_US, RELEASE_US, STEP_US = 500_000, 1_000_000, 100_000


class RobotiqEPick(RobotiqUnit):
    """An EPick: a pressure request below 100 grips, with a minimum pressure and a time-out in the advanced mode."""

    name = "robotiq-epick"
    physics = VacuumCircuit
    silence_us = 1_500_000

    def __init__(self, devices: Mapping[int, Device], tell: Tell) -> None:
        super().__init__(devices, tell)
        self._cup = devices[0]
        self._grips = self._has_released = self._has_gripped = False
        self._begun_at = self._done_at = 0

    @property
    def due(self) -> int | None:
        return self._heard_at + self.silence_us if self.state == ACTIVE else None

    def status(self) -> list[int]:
        mode, goes = self.command[0] & MODE, self.wants(GTO) and self.state == ACTIVE
        shown = self._object() if goes else UNKNOWN
        suction = GRIPPING if self._grips else PASSIVE_RELEASE if goes and self._has_released else STANDBY
        return [shown << 6 | goes << 3 | mode, suction, 0, 0, self._pressure, 0]

    def advance(self, at: int) -> None:
        super().advance(at)
        if self.state == ACTIVE and at - self._heard_at >= self.silence_us:
            self.state, self.fault = RESET, IDLE
            self.stop()
        if not self._grips:
            return
        self._has_gripped = self._has_gripped or self._pressure <= self._minimum
        if not self._has_gripped and at - self._begun_at >= self._timeout_us:
            self.fault = GRIP_TIMEOUT
            self.stop()

    def stop(self) -> None:
        if self._grips:
            self._grips = False
            self._tell(0, False)

    def activate(self, at: int) -> None:
        self._done_at, self._has_released = at + ACTIVATION_US, False
        self.stop()

    def obey(self, at: int) -> None:
        if not self.wants(GTO):
            self.stop()
        elif self.command[3] >= AMBIENT:
            self._has_released, self.fault = True, 0
            self.stop()
        elif self._has_released and not self._grips:
            self._grips, self._has_gripped, self._begun_at, self.fault = True, False, at, 0
            self._tell(0, True)

    def release(self) -> None:
        self._done_at = self._now + RELEASE_US
        self.stop()

    def has_finished(self, at: int) -> bool:
        return at >= self._done_at

    def settle(self) -> None:
        self._done_at, self._has_released = self._now, True
        self.advance(self._now)

    @property
    def _pressure(self) -> int:
        """Pressure as it is sent; the pump stops at the one that was asked for."""
        pressure = AMBIENT + round(self._cup.pressure_kpa or 0.0)
        return min(max(pressure, self.command[3] if self._grips else 0), LONGEST)

    @property
    def _minimum(self) -> int:
        return self.command[5] if self.command[0] & MODE else AUTOMATIC_MINIMUM

    @property
    def _timeout_us(self) -> int:
        return (self.command[4] if self.command[0] & MODE else LONGEST) * STEP_US

    def _object(self) -> int:
        if not self._grips:
            return NONE
        if self._pressure <= self.command[3]:
            return AT_MAXIMUM
        if self._pressure <= self._minimum:
            return AT_MINIMUM
        return NONE if self._has_gripped else UNKNOWN
