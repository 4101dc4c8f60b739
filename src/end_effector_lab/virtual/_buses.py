"""All buses of a tool that are commanded, in virtual time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from end_effector_hal.description import Description
from end_effector_lab.testbench import Bench

if TYPE_CHECKING:
    from ._bus import BusDevices, VirtualBus


class VirtualBuses:
    """All buses of a tool that are commanded.

    Args:
        description: of the tool.
        bench: what is measured.
        obey: called with the name and the level of an output that was commanded.
        clock: µs.
        active: outputs that are active at the start.
    """

    def __init__(
        self,
        description: Description,
        bench: Bench,
        obey: Callable[[str, bool], None],
        clock: Callable[[], int],
        active: Mapping[str, bool],
    ) -> None:
        self._description, self._clock = description, clock
        self.devices: dict[str, BusDevices] = {}
        """At the far ends, by their links."""
        if description.buses:  # a tool without one needs no pymodbus
            from ._bus import BusDevices

            self.devices = {name: BusDevices(description, name, bench, obey) for name in description.buses}
        for each in self.devices.values():
            each.start(active, clock())
        self.masters: list[VirtualBus] = []
        """Of the arbiter that lives, is starting, or ends."""

    def open(self) -> dict[str, VirtualBus]:
        """A new arbiter takes the ports; each output with its bus."""
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
        """Whether an arbiter need not wait any more for what the devices report."""
        return all(each.adopted for each in self.masters)

    @property
    def news(self) -> bool:
        """Whether a device has done something since it was asked last."""
        return any(each.news for each in self.masters)

    def end(self) -> None:
        """The arbiter ends in order."""
        for each in self.masters:
            each.end()
        self.forget_ended()

    def forget_ended(self) -> None:
        """Those that have given their port back are gone."""
        self.masters = [each for each in self.masters if not each.over]

    def kill(self) -> None:
        """The arbiter dies, and nobody speaks to the devices any more."""
        self.masters = []

    def lose_power(self) -> None:
        """The devices are without power, too."""
        self.kill()
        for each in self.devices.values():
            each.lose_power(self._clock())
