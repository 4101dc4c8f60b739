"""Base classes of all driven devices, the plant that advances those of one tool together, and the physics by kind."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from copy import copy
from typing import Any, ClassVar, Self

from end_effector_hal.errors import UsageError
from end_effector_hal.plugins import Plugins

from ._parts import STEP_US, Model, SolvedModel, Supply, Valve

ACTUATOR, PRESSURE, LEAKS, PARTS, CHANGER = "actuator", "pressure", "leaks", "parts", "changer"
STICKS = "sticks"
"""Traits that the faults of a scenario require: the device holds something, has a pressure sensor, can leak, can be
without a part, is a tool changer, or its parts can stick.
"""


class Device(Model):
    """A model behind a valve that a line switches.

    Attributes:
        traits: traits that decide its possible faults: `ACTUATOR`, `PRESSURE`, `LEAKS`, `PARTS`, `CHANGER`, `STICKS`.
        grips_bit, released_bit, empty_bit: names of its `bits` that show a completed activation, a completed
        deactivation, or a grip without a part; empty: there is no such bit.
        valve_us: the shortest and the longest dead time of its valve, µs.
    """

    traits: ClassVar[frozenset[str]] = frozenset({ACTUATOR})
    grips_bit: ClassVar[str] = ""
    released_bit: ClassVar[str] = ""
    empty_bit: ClassVar[str] = ""
    valve_us: ClassVar[tuple[int, int]] = (15_000, 60_000)

    def __init__(self, valve: Valve, start: int = 0) -> None:
        super().__init__(start)
        self.valve = valve

    @classmethod
    def on_air(cls, valve: Valve, supply: Supply, start: int) -> Self:
        """Return a new device behind this valve with this air supply, from ``start`` (µs) on."""
        return cls(valve, start=start)

    def command(self, active: bool, at: int) -> None:
        self.valve.command(active, at)

    def lose(self, at: int) -> None:
        """Release the held part with the valve still energised: by default, the air supply of this device fails."""
        self.valve.command(False, at)

    def leak(self, litres_min: float, grows_l_min_s: float = 0.0) -> None:
        """Set the leak, l/min, and its growth per second of suction; only devices with the trait `LEAKS` can leak."""
        if litres_min or grows_l_min_s:
            raise ValueError(f"{type(self).__name__} has no leak")

    def meet(self, part: bool) -> None:
        """Set whether there is a part to grip; only devices with the trait `PARTS` can be without one."""
        if not part:
            raise ValueError(f"{type(self).__name__} has no parts")

    def stick(self, sticks: bool) -> None:
        """Set whether a released part sticks until it is blown off; only for devices with the trait `STICKS`."""
        if sticks:
            raise ValueError(f"nothing sticks to {type(self).__name__}")

    def blow(self, active: bool, at: int) -> None:
        """Switch the blow-off valve; most devices have none."""

    @property
    def draw_kpa(self) -> float:
        """Present pressure drop of the supply due to this device, kPa."""
        return 0.0

    @abstractmethod
    def settle(self, active: bool) -> None:
        """Set the state that the device has after being active, or inactive, for a long time."""

    @property
    def pressure_kpa(self) -> float | None:
        """Gauge pressure at its sensor, kPa (vacuum negative); None: it has no pressure sensor."""
        return None

    @property
    def grips(self) -> bool:
        """Whether the activation is complete; sensors that only conditions use show it."""
        return self.bits[self.grips_bit] if self.grips_bit else self.settled and self.valve.is_open

    @property
    def is_released(self) -> bool:
        """Whether the deactivation is complete."""
        return self.bits[self.released_bit] if self.released_bit else self.settled and not self.valve.is_open

    @property
    def is_empty(self) -> bool:
        """Whether the device closed without a part."""
        return bool(self.empty_bit) and self.bits[self.empty_bit]

    @property
    @abstractmethod
    def bits(self) -> Mapping[str, bool]:
        """Its switches by meaning: ``extended`` is sent on the channel that ``extended_bit`` names."""


class SolvedDevice(Device, SolvedModel):
    """A device that is computed in closed form until the next switching; see `SolvedModel`."""

    def command(self, active: bool, at: int) -> None:
        super().command(active, at)
        self.stale = True

    def lose(self, at: int) -> None:
        super().lose(at)
        self.stale = True

    def begin(self) -> None:
        self.valve.advance(self.now)
        super().begin()

    def switches_at(self) -> int | None:
        return self.valve.switches_at


class Plant(Model):
    """Devices that affect each other only by the pressure of their supply.

    Solved devices jump from one switching to the next; while a stepping device moves, all advance in steps.

    Args:
        supply: the air supply of all devices.
        devices: devices by name.
        start: time of the initial state of all of them, µs.
    """

    def __init__(self, supply: Supply, devices: Mapping[str, Device], start: int = 0) -> None:
        super().__init__(start)
        self.supply = supply
        self.devices = dict(devices)
        self._solved = tuple(each for each in self.devices.values() if isinstance(each, SolvedModel))
        self._stepping = tuple(each for each in self.devices.values() if not isinstance(each, SolvedModel))
        self._models: tuple[SolvedModel, ...] = (supply, *self._solved)
        self._stepped = True

    @property
    def settled(self) -> bool:
        return self.supply.settled and all(device.settled for device in self.devices.values())

    def step(self) -> None:
        self._go(self.now + STEP_US)

    def advance(self, at: int) -> None:
        at = self.now + (at - self.now) // STEP_US * STEP_US
        while self.now < at:
            self.now = self._go(at)

    @property
    def quiet_before(self) -> int | None:
        """Earliest time, µs, at which something may switch without a new command; None: nothing will."""
        if any(each.stale for each in self._models) or not all(each.settled for each in self._stepping):
            return self.now
        return min([each.due for each in self._models if each.due is not None], default=None)

    def ahead(self, at: int) -> Self:
        """Return a copy in the state of ``at`` (µs); raises ValueError if something may switch by then."""
        to = self.now + (at - self.now) // STEP_US * STEP_US
        if (switches := self.quiet_before) is not None and switches <= to:
            raise ValueError(f"something switches at {switches} µs")
        other = copy(self)
        other.supply = self.supply.ahead(to)
        other.devices = {
            name: each.ahead(to) if isinstance(each, SolvedDevice) else each
            for name, each in self.devices.items()
        }
        other._solved = tuple(each for each in other.devices.values() if isinstance(each, SolvedModel))
        other._models = (other.supply, *other._solved)
        return other

    def _go(self, at: int) -> int:
        """Advance to ``at``, or to the first switching; return the time reached."""
        moving = [device for device in self._stepping if not device.settled]
        if moving or self._stepped or any(model.stale for model in self._models):
            self._begin()
        self._stepped = bool(moving)
        to = self.now + STEP_US if moving else at
        for model in self._models:
            if model.due is not None and model.due < to:
                to = model.due
        for device in self._stepping:
            device.now = self.now
        for device in moving:
            device.step()
        for device in self._stepping:
            device.now = to
        for model in self._models:
            model.go(to)
        return to

    def _begin(self) -> None:
        """Start devices with a new command, and all devices on the supply if the supply starts."""
        for model in self._solved:
            if model.stale:
                model.begin()
        draw_kpa = sum([device.draw_kpa for device in self.devices.values()])
        if draw_kpa != self.supply.draw_kpa:
            self.supply.load(draw_kpa)
        if self.supply.stale:
            self.supply.begin()
            for model in self._solved:
                model.begin()


GROUP = "end_effector_hal.physics"
OWN = {
    "vacuum": "end_effector_lab.testbench.physics:VacuumCircuit",
    "cylinder": "end_effector_lab.testbench.physics:Cylinder",
    "gripper": "end_effector_lab.testbench.physics:Fingers",
    "magnet": "end_effector_lab.testbench.physics:HoldingMagnet",
}


def physics_of(kind: str) -> type[Device]:
    """Return the physics of a kind of actuator.

    Raises:
        UsageError: the kind has no physics (the message lists those that have), or it cannot be loaded.
    """
    return _PHYSICS.get(kind)


def _checked(physics: Any) -> type[Device]:
    if not (isinstance(physics, type) and issubclass(physics, Device)):
        raise UsageError("this is no subclass of end_effector_lab.testbench.physics.Device.")
    return physics


_PHYSICS: Plugins[type[Device]] = Plugins(GROUP, "simulated kind of actuator", OWN, _checked, make=False)
