"""All devices of one tool in step."""

from __future__ import annotations

from collections.abc import Mapping

from end_effector_lab.testbench.physics._device import Device
from end_effector_lab.testbench.physics._parts import Model
from tests.unit.testbench.stepping.parts import Supply


class Plant(Model):
    """Devices that feel each other by the pressure of their supply only.

    Args:
        supply: feeds them all.
        devices: by name.
        start: µs, the time of the initial state of all of them.
    """

    def __init__(self, supply: Supply, devices: Mapping[str, Device], start: int = 0) -> None:
        super().__init__(start)
        self.supply = supply
        self.devices = dict(devices)
        self._models: tuple[Model, ...] = (supply, *self.devices.values())

    @property
    def settled(self) -> bool:
        return all(model.settled for model in self._models)

    def step(self) -> None:
        self.supply.draw_kpa = sum(device.draw_kpa for device in self.devices.values())
        for model in self._models:
            model.now = self.now
            model.step()
