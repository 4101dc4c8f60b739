# ruff: noqa: D102 the name of a test says what must hold
"""Tests that the physics of every kind must pass; inherit `PhysicsConformance` in your tests (needs pytest).

class TestJawPhysics(PhysicsConformance):
    kind = Jaw()
    physics = JawPhysics
    stanza = {"line": "JAW"}
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from end_effector_hal.kinds import DeviceKind
from end_effector_hal.kinds.conformance import FixedReadings
from end_effector_hal.kinds.stanza import Actuator, Supply, named
from end_effector_hal.signals import Kind, Value
from end_effector_hal.vocabulary import Evidence

from ._device import LEAKS, PARTS, PRESSURE, Device
from ._parts import STEP_US, Valve
from ._parts import Supply as Air

SAMPLE_US = 20 * STEP_US


class PhysicsConformance:
    """Tests of physics; set ``kind``, ``physics``, and ``stanza``: the keys that the kind requires, with all channels
    named.
    """

    kind: ClassVar[DeviceKind[Any]]
    physics: ClassVar[type[Device]]
    stanza: ClassVar[Mapping[str, object]]

    @property
    def actuator(self) -> Actuator:
        return self.kind.stanza.model_validate({"kind": self.kind.name, **self.stanza})

    def device(self) -> Device:
        return self.physics.on_air(Valve(max(self.physics.valve_us)), Air(), 0)

    def shown(self, device: Device) -> FixedReadings:
        """Return the readings of the device's sensors."""
        actuator, values = self.actuator, {"supply": 600_000}
        seen: dict[str, Value] = {**values}
        for key in self.kind.channels:
            if named(getattr(actuator, key.key)) is None:
                continue
            if key.carries is Kind.BIT:
                seen[getattr(actuator, key.key)] = device.bits[key.meaning]
            elif device.pressure_kpa is not None:
                seen[getattr(actuator, key.key)] = round(device.pressure_kpa * 1000)
        return FixedReadings(seen)

    def judged(self, device: Device, detector: Any, seconds: float) -> list[Evidence]:
        """Return the evidence of every sample in the next ``seconds``."""
        levels = []
        for at in range(device.now + SAMPLE_US, device.now + round(seconds * 1e6), SAMPLE_US):
            device.advance(at)
            levels.append(detector.sample(self.shown(device), at))
        return levels

    def test_it_is_confirmed_and_gone_within_the_times_of_its_stanza(self) -> None:
        device, actuator = self.device(), self.actuator
        detector = self.kind.detector(actuator, Supply())
        assert self.judged(device, detector, 1.0)[-1] is Evidence.GONE
        device.command(True, device.now)
        assert self.judged(device, detector, actuator.timeout_s)[-1] is Evidence.CONFIRMED
        device.command(False, device.now)
        assert self.judged(device, detector, actuator.release_s)[-1] is Evidence.GONE

    def test_what_is_lost_is_no_longer_confirmed(self) -> None:
        device, actuator = self.device(), self.actuator
        detector = self.kind.detector(actuator, Supply())
        device.command(True, 0)
        self.judged(device, detector, actuator.timeout_s)
        device.lose(device.now)
        assert self.judged(device, detector, actuator.release_s)[-1] is not Evidence.CONFIRMED

    def test_settled_is_what_it_comes_to(self) -> None:
        for active in (False, True):
            settled, waited = self.device(), self.device()
            settled.settle(active)
            waited.command(active, 0)
            waited.advance(60_000_000)
            assert settled.bits == waited.bits
            assert waited.settled

    def test_its_traits_are_what_it_has(self) -> None:
        device = self.device()
        assert (device.pressure_kpa is not None) is (PRESSURE in self.physics.traits)
        if LEAKS in self.physics.traits:
            device.leak(4.0)
        if PARTS in self.physics.traits:
            device.meet(False)
