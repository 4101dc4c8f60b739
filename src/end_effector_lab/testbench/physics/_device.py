"""What every driven device of the bench has, and all devices of one tool in step."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from copy import copy
from typing import ClassVar, Self

from ._parts import STEP_US, Model, SolvedModel, Supply, Valve

ACTUATOR, PRESSURE, LEAKS, PARTS, CHANGER = "actuator", "pressure", "leaks", "parts", "changer"
STICKS = "sticks"
"""What the faults of a scenario ask for: it holds something, has a pressure sensor, can leak, may have no part to
grip, is a tool changer, has parts that may stick to it."""


class Device(Model):
    """A model behind a valve that a line switches.

    Attributes:
        traits: which faults it can have: `ACTUATOR`, `PRESSURE`, `LEAKS`, `PARTS`, `CHANGER`, `STICKS`.
        grips_bit, released_bit, empty_bit: which of its `bits` shows that it has done what an activation is for, what a
            deactivation is for, or that it gripped nothing; empty: none does.
        valve_us: the least and the longest dead time of its valve.
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
        """A new one behind this valve, on this air, from ``start`` (µs) on."""
        return cls(valve, start=start)

    def command(self, active: bool, at: int) -> None:
        self.valve.command(active, at)

    def lose(self, at: int) -> None:
        """Lose what is held, with the valve still energised: here, the air supply of this device fails."""
        self.valve.command(False, at)

    def leak(self, litres_min: float, grows_l_min_s: float = 0.0) -> None:
        """Leak this much from now on, and more with each second of suction; only what `LEAKS` does."""
        if litres_min or grows_l_min_s:
            raise ValueError(f"{type(self).__name__} has no leak")

    def meet(self, part: bool) -> None:
        """Whether there is a part to grip from now on; only what has `PARTS` can do without."""
        if not part:
            raise ValueError(f"{type(self).__name__} has no parts")

    def stick(self, sticks: bool) -> None:
        """Whether the part stays on it when it is released, until it is blown off; only what `STICKS` does."""
        if sticks:
            raise ValueError(f"nothing sticks to {type(self).__name__}")

    def blow(self, active: bool, at: int) -> None:
        """Its blow-off valve is energised, or not any more; of most devices nothing hangs on it."""

    @property
    def draw_kpa(self) -> float:
        """How far it pulls down the supply at this moment."""
        return 0.0

    @abstractmethod
    def settle(self, active: bool) -> None:
        """Take the state that it has after being active, or inactive, for a long time."""

    @property
    @abstractmethod
    def pressure_kpa(self) -> float | None:
        """Gauge pressure at its sensor (vacuum negative); ``None``: it has no pressure sensor."""

    @property
    def grips(self) -> bool:
        """Whether it has done what an activation is for; it decides what sensors show that only conditions know."""
        return self.bits[self.grips_bit] if self.grips_bit else self.settled and self.valve.is_open

    @property
    def is_released(self) -> bool:
        """Whether it has done what a deactivation is for."""
        return self.bits[self.released_bit] if self.released_bit else self.settled and not self.valve.is_open

    @property
    def is_empty(self) -> bool:
        """Whether it has gripped nothing."""
        return bool(self.empty_bit) and self.bits[self.empty_bit]

    @property
    @abstractmethod
    def bits(self) -> Mapping[str, bool]:
        """Its switches, by what they mean: ``extended`` is shown on the channel that ``extended_bit`` names."""


class SolvedDevice(Device, SolvedModel):
    """A device that is solved until something switches; see `SolvedModel`."""

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
    """Devices that feel each other by the pressure of their supply only.

    Those that are solved go from one switching to the next at once; while another one moves, all go in steps.

    Args:
        supply: feeds them all.
        devices: by name.
        start: µs, the time of the initial state of all of them.
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
        """µs at which something may switch if nobody does anything; None: nothing does."""
        if any(each.stale for each in self._models) or not all(each.settled for each in self._stepping):
            return self.now
        return min([each.due for each in self._models if each.due is not None], default=None)

    def ahead(self, at: int) -> Self:
        """Another plant with the state of ``at`` (µs), before anything switches; raises ValueError: it may by then."""
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
        """Go to ``at``, or as far as nothing switches; returns how far that was."""
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
        """Start devices with a new command, and those on the supply once it starts."""
        for model in self._solved:
            if model.stale:
                model.begin()
        draw_kpa = sum([device.draw_kpa for device in self.devices.values()])
        if draw_kpa != self.supply.draw_kpa:
            self.supply.draw_kpa = draw_kpa
        if self.supply.stale:
            self.supply.begin()
            for model in self._solved:
                model.begin()
