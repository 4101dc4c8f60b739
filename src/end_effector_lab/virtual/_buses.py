"""All commanded buses of a tool in virtual time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from end_effector_hal.description import Description
from end_effector_lab.testbench import Bench, Models

if TYPE_CHECKING:
    from ._bus import BusDevices, VirtualBus


class VirtualBuses:
    """All commanded buses of a tool.

    Args:
        description: the description of the tool.
        bench: provides the measured values.
        obey: called with the name and level of a commanded output.
        clock: returns the time, µs.
        active: outputs that are active at the start.
        models: units that have a model.
    """

    def __init__(
        self,
        description: Description,
        bench: Bench,
        obey: Callable[[str, bool], None],
        clock: Callable[[], int],
        active: Mapping[str, bool],
        models: Models,
    ) -> None:
        self._description, self._clock = description, clock
        self.devices: dict[str, BusDevices] = {}
        """The devices of the buses, by their links."""
        if description.buses:  # a tool without one needs no pymodbus
            from ._bus import BusDevices

            self.devices = {
                name: BusDevices(description, name, bench, obey, models) for name in description.buses
            }
        for each in self.devices.values():
            each.start(active, clock())
        self.masters: list[VirtualBus] = []
        """Bus masters of the living, starting or ending arbiter."""

    def open(self) -> dict[str, VirtualBus]:
        """Open the ports for a new arbiter; return the bus of each output."""
        if not self.devices:
            return {}
        from ._bus import VirtualBus

        found: dict[str, VirtualBus] = {}
        for name, devices in self.devices.items():
            master = VirtualBus(self._description, name, devices, self._clock)
            self.masters.append(master)
            found |= dict.fromkeys(self._description.buses[name], master)
        return found

    @property
    def adopted(self) -> bool:
        """Whether an arbiter no longer waits for the devices' reports."""
        return all(each.adopted for each in self.masters)

    @property
    def news(self) -> bool:
        """Whether a device has changed since the last query."""
        return any(each.news for each in self.masters)

    def end(self) -> None:
        """Begin the proper end of the arbiter."""
        for each in self.masters:
            each.end()
        self.forget_ended()

    def forget_ended(self) -> None:
        """Remove the masters that have released their port."""
        self.masters = [each for each in self.masters if not each.over]

    def kill(self) -> None:
        """Remove all masters, since the arbiter dies; no request reaches the devices any more."""
        self.masters = []

    def lose_power(self) -> None:
        """Cut the power of the devices as well."""
        self.kill()
        for each in self.devices.values():
            each.lose_power(self._clock())
