"""The simulated end-effector: its inputs are line levels, its outputs are sensor values; sans-IO."""

from __future__ import annotations

import math
from collections.abc import Mapping
from random import Random

from end_effector_hal.codecs import carrier_of
from end_effector_hal.description import Description, used_channels
from end_effector_hal.description import ToolChanger as Changer
from end_effector_hal.errors import UsageError
from end_effector_hal.kinds import kind_of
from end_effector_hal.kinds.stanza import named
from end_effector_hal.signals import Kind, Value

from ._evidence import shown_by_conditions
from ._noise import Noise, disturbed, of_another_unit
from ._scenario import (
    TOOL_CHANGER,
    Effect,
    Scenario,
    device_physics,
    did_you_mean,
    parse_scenario,
)
from .physics import Device, Plant, Supply, Valve


class Station:
    """Controls a device's valve from the level of a line, with the faults of an :class:`Effect`.

    Args:
        device: the device that the line drives.
        active: level at the start; it has lasted so long that the device has settled.
        effect: faults of the device.
    """

    def __init__(self, device: Device, *, active: bool = False, effect: Effect | None = None) -> None:
        self.device = device
        self.active = active
        self.effect = effect or Effect()
        self.due: int | None = None  # µs, when what is held will be lost
        self._activations = 0
        self._works = active
        self._have(self.effect)
        device.settle(active)
        self._expect_loss(device.now)

    def line(self, active: bool, at: int) -> None:
        """Set the level of the line from ``at`` (µs) on."""
        if active == self.active:
            return
        self.active = active
        if active:
            self._activations += 1
            self._works = self._activations > self.effect.dead_activations
        self._drive(at)

    def suffer(self, effect: Effect, at: int) -> None:
        """Apply another fault from ``at`` (µs) on; an activation that has worked already keeps its effect."""
        self.effect, self._activations = effect, 0
        if self.active and not self._works:
            self._activations = 1
            self._works = effect.dead_activations < 1
        self._have(effect)
        self._drive(at)

    def lose(self) -> None:
        """Drop the held part at the time ``due``."""
        if self.due is not None:
            self.device.lose(self.due)
            self.due = None

    def _have(self, effect: Effect) -> None:
        """Let the device have the faults that do not depend on its line."""
        self.device.leak(effect.leak_l_min, effect.leak_grows_l_min_s)
        self.device.meet(not effect.no_part)
        self.device.stick(effect.sticks)

    def _drive(self, at: int) -> None:
        if self.active:
            self.device.command(self._works, at)
        elif not (self.effect.stuck and self._works):
            self.device.command(False, at)
            self._works = False
        self._expect_loss(at)

    def _expect_loss(self, at: int) -> None:
        after = self.effect.lost_after_us
        self.due = at + after if after is not None and self.active and self._works else None


NOISE_KPA = 0.1
NOISE_QUANTITY = 0.001
"""Noise of quantities other than pressures, in their unit."""
BOOT_US = 300_000


class Bench:
    """Everything at the other end of the wires, for any description.

    Args:
        description: the description of the tool.
        scenario: the faults, as text or parsed.
        seed: seed of the valves' dead times and of the noise.
        start: time of the initial state, µs.
        levels: lines that are active at the start; their devices have settled, so that a restarted bench still holds
            its part.

    Raises:
        UsageError: the scenario cannot be used.
    """

    def __init__(
        self,
        description: Description,
        scenario: Scenario | str = "nominal",
        seed: int = 0,
        *,
        start: int = 0,
        levels: Mapping[str, bool] | None = None,
    ) -> None:
        self._description = description
        self.scenario = self._parsed(scenario)
        self._noise = Noise(seed)
        self._start = self._chosen_at = start
        self._booted: dict[str | None, int] = dict.fromkeys((None, *description.links), start)
        self._frozen: dict[str, Value] = {}
        supply = Supply(self._supply_kpa(), start=start)
        devices = {
            name: physics.on_air(
                Valve(self._noise.between(f"valve {name}", *physics.valve_us)), supply, start
            )
            for name, physics in device_physics(description).items()
        }
        self._plant = Plant(supply, devices, start)
        lines = self.lines
        self._stations = {
            name: Station(
                device, active=(levels or {}).get(lines[name], False), effect=self.scenario.effect(name)
            )
            for name, device in devices.items()
        }
        self._conditions = shown_by_conditions(description)
        self._sensors = [
            (
                name,
                actuator.channel,
                [
                    (bit, key.meaning)
                    for key in kind_of(actuator).channels
                    if key.carries is Kind.BIT and (bit := named(getattr(actuator, key.key)))
                ],
            )
            for name, actuator in description.ordered
        ]
        carried, used = carrier_of(description).channels, used_channels(description)
        self._at_rest: dict[str, Value] = {
            name: False if carried[name] is Kind.BIT else 0
            for name in carried
            if name not in used and (name in description.channels or carried[name] is not Kind.BIT)
        }
        """Values of channels that nothing uses; a device sends them all the same."""
        self._quantities = frozenset(name for name, kind in carried.items() if kind is Kind.QUANTITY)
        self._driven = tuple(self._stations.values())
        self._alarms = [name for name, declared in description.channels.items() if declared.alarm]
        self._by_line = {line: self._stations[name] for name, line in lines.items()}
        opposites = self._description.opposites
        self._second = {each.line: self._by_line[line] for line, each in opposites.items()}
        self._two_coils = frozenset(opposites)
        self._plain = {each.line for each in self._description.outputs.values()}
        self._blow_offs = {
            line: devices[name] for name, line in description.blow_off_lines.items() if name in devices
        }

    @property
    def lines(self) -> dict[str, str]:
        """Line of every device: the tool changer's first, then those of the actuators in their sequence."""
        changer = self._description.tool_changer
        first = {TOOL_CHANGER: changer.line} if changer else {}
        return first | {name: actuator.line for name, actuator in self._description.ordered}

    @property
    def devices(self) -> Mapping[str, Device]:
        """The simulated devices by name, in their real state, which sensors and links may report differently."""
        return self._plant.devices

    def line(self, name: str, level: bool, at: int) -> None:
        """Set the level of the line ``name`` from ``at`` (µs) on; a plain output moves nothing.

        Raises:
            UsageError: the description has no device on that line.
        """
        station = self._by_line.get(name) or self._second.get(name)
        if name in self._plain:
            return
        if station is None and name not in self._blow_offs:
            raise UsageError(
                f"no device is connected to the line {name!r}.",
                todo=did_you_mean(name, [*self._by_line, *self._second, *self._blow_offs]),
            )
        self._advance(at)
        if station is None:
            self._blow_offs[name].blow(level, at)
            return
        if name in self._second:  # the spool stays where a coil has moved it
            if level:
                station.line(False, at)
        elif level or name not in self._two_coils:
            station.line(level, at)

    def choose(self, scenario: Scenario | str, at: int) -> None:
        """Switch to another scenario from ``at`` (µs) on.

        Raises:
            UsageError: the scenario cannot be used; nothing has changed.
        """
        parsed = self._parsed(scenario)
        self._advance(at)
        self._booted = {link: self.booted(at, link) for link in self._booted}
        self.scenario, self._chosen_at, self._frozen = parsed, at, {}
        self._plant.supply.regulate(self._supply_kpa())
        for name, station in self._stations.items():
            station.suffer(parsed.effect(name), at)

    def booted(self, at: int, link: str | None = None) -> int:
        """Return the time, µs, at which the sending device was or will be ready after its last start before ``at``."""
        after_us = self.scenario.on_link(link).reboot_after_us
        return self._since(after_us) + BOOT_US if self._is_over(after_us, at) else self._booted[link]

    def restarts_at(self, link: str | None) -> int | None:
        """Return the time, µs, at which the scenario lets the device at a link restart; None: it does not."""
        after_us = self.scenario.on_link(link).reboot_after_us
        return None if after_us is None else self._since(after_us)

    def silent(self, at: int, link: str | None = None) -> bool:
        """Return whether a link is silent at ``at`` (µs); for None, whether the inputs of the board are silent."""
        after_us = self.scenario.on_link(link).silent_after_us
        return self._is_over(after_us, at) or at < self.booted(at, link) or self.closed(at, link)

    def closed(self, at: int, link: str | None = None) -> bool:
        """Return whether the device at the address of a link refuses connections at ``at`` (µs)."""
        return self._is_over(self.scenario.on_link(link).closed_after_us, at)

    def foreign_write_at(self, link: str | None) -> int | None:
        """Return the time, µs, at which another client makes the outputs on a link inactive; None: none does."""
        after_us = self.scenario.on_link(link).foreign_write_after_us
        return None if after_us is None else self._since(after_us)

    def exchanged(self, at: int, link: str | None = None) -> bool:
        """Return whether another device answers on a link at ``at`` (µs)."""
        return self._is_over(self.scenario.on_link(link).other_device_after_us, at)

    def cuts(self, at: int, link: str | None = None) -> bool:
        """Return whether the connection of a link is reset in the middle of the answer at ``at`` (µs)."""
        share = self.scenario.on_link(link).cut
        return share > 0 and self._noise.random(f"cut {link} {at - self._start}").random() < share

    def corrupt(self, data: bytes, at: int, link: str | None = None) -> bytes:
        """Return the bytes that arrive if ``data`` is sent over a link at ``at`` (µs)."""
        effect = self.scenario.on_link(link)
        babble = self._is_over(effect.babble_after_us, at)
        if not (babble or effect.disturbs):
            return data
        return disturbed(data, effect, self._chance(at, link), babble=babble)

    def answered(self, data: bytes, at: int, link: str | None = None) -> tuple[bytes, int]:
        """Return the actual answer of a polled device that should answer ``data`` at ``at`` (µs), and its delay, µs."""
        effect = self.scenario.on_link(link)
        if not effect.misanswers:
            return data, effect.late_us
        chance = self._chance(at, link)
        if chance.random() < effect.unanswered:
            return b"", effect.late_us
        if chance.random() < effect.another:
            data = of_another_unit(data)
        return data * (1 + (chance.random() < effect.twice)), effect.late_us

    def _chance(self, at: int, link: str | None) -> Random:
        """Return a random generator for this time and link, independent of other links."""
        return self._noise.random(" ".join(filter(None, ("link", link, str(at - self._start)))))

    def _since(self, after_us: int | None) -> int:
        return self._chosen_at + (after_us or 0)

    def _is_over(self, after_us: int | None, at: int) -> bool:
        return after_us is not None and at >= self._since(after_us)

    def sample(self, at: int) -> dict[str, Value]:
        """Return the readings of all sensors at ``at`` (µs).

        Returns:
            channel -> gauge Pa (vacuum negative), bit, or None: invalid.
        """
        self._advance(at)
        return self._values(self._plant, at)

    def corners(self, at: int, until: int) -> tuple[dict[str, Value], dict[str, Value]] | None:
        """Return the least and the largest reading of every sensor from ``at`` to ``until`` if no line changes.

        Args:
            at: present time, µs.
            until: end of the interval, µs.

        Returns:
            Lower and upper readings by channel; None: a bit, an alarm or the validity of a reading changes.

        Raises:
            ValueError: an event may happen by then; see `quiet_until`.
        """
        self._advance(at)
        plant = self._plant.ahead(until)
        low, high = self._values(self._plant, at), self._values(plant, until)
        for name, one in low.items():
            other = high[name]
            if one is None or isinstance(one, bool) or other is None or name in self._alarms:
                if one is not other:
                    return None
                continue
            noise = NOISE_QUANTITY if name in self._quantities else NOISE_KPA
            most = math.ceil(2 * noise * self._noise.most * 1000)
            low[name], high[name] = min(one, other) - most, max(one, other) + most
        return low, high

    def quiet_until(self, at: int, link: str | None) -> int | None:
        """Return the time, µs, until which nothing happens by itself: no fault begins, no valve switches, no device
        restarts.

        Args:
            at: time of the last sample, µs; the result may be earlier.
            link: the link whose faults count.

        Returns:
            The time; None: no event is to come.
        """
        effect = self.scenario.on_link(link)
        if effect.disturbs or at < self.booted(at, link):
            return at
        happen = [
            effect.silent_after_us,
            effect.babble_after_us,
            effect.closed_after_us,
            effect.foreign_write_after_us,
            effect.other_device_after_us,
            *self._frozen_after_us,
        ]
        if effect.reboot_after_us is not None and not self._is_over(effect.reboot_after_us, at):
            happen.append(effect.reboot_after_us)
        dues = [self._since(after_us) for after_us in happen if after_us is not None]
        dues += [station.due for station in self._driven if station.due is not None]
        if (switches := self._plant.quiet_before) is not None:
            dues.append(switches)
        return min(dues) - 1 if dues else None

    @property
    def _frozen_after_us(self) -> list[int]:
        """Delays of the sensors that freeze, µs; they keep the value of the first sample after that."""
        every = [effect.frozen_after_us for effect in self.scenario.effects.values()]
        return [after_us for after_us in every if after_us is not None]

    def leaves_no_trace(self, at: int, link: str | None, *, unheard: bool) -> bool:
        """Return whether a sample at ``at`` (µs) can have no later effect: no reader (``unheard``) or a silent link,
        and no sensor that freezes.
        """
        return (unheard or self.silent(at, link)) and not self._frozen_after_us

    def _values(self, plant: Plant, at: int) -> dict[str, Value]:
        """Return the readings of all sensors of a plant."""
        scenario = self.scenario
        values: dict[str, Value] = self._at_rest | {
            "tool_present": scenario.tool_present,
            "in_stand": scenario.in_stand,
            "estop_ok": scenario.estop_ok,
        }
        description, devices = self._description, plant.devices
        for name, channel, bits in self._sensors:
            device = devices[name]
            if (kpa := device.pressure_kpa) is not None:
                values[channel] = self._shown(name, channel, kpa, at)
            if bits:
                shown = device.bits
                for bit, meaning in bits:
                    values[bit] = shown[meaning]
        if description.tool_changer is not None:
            values |= self._changer_bits(description.tool_changer, devices[TOOL_CHANGER].bits)
        if description.e_stop is not None:
            values[description.e_stop.channel] = scenario.estop_ok
        for name, conditions in self._conditions.items():
            for channel, value in conditions.at(devices[name]):
                if isinstance(value, bool):
                    values[channel] = value
                else:
                    values[channel] = self._shown(name, channel, value, at)
        for name in self._alarms:
            if name in scenario.alarms or name not in values:
                code = scenario.alarms.get(name, 0)
                values[name] = code if description.channels[name].kind is Kind.CODE else bool(code)
        values[description.supply.channel] = self._pa(description.supply.channel, plant.supply.kpa, at)
        if scenario.effects:
            self._swap(values)
        return values

    def _changer_bits(self, changer: Changer, places: Mapping[str, bool]) -> dict[str, Value]:
        """Return the readings of the tool changer's and the stand's sensors if the changer is at ``places``."""
        effect = self.scenario.effect(TOOL_CHANGER)
        there = {
            changer.present_bit: (self.scenario.tool_present, None),
            changer.stand_bit: (self.scenario.in_stand, effect.stand_shows),
            changer.locked_bit: (places["locked"], effect.locked_shows),
            changer.unlocked_bit: (places["unlocked"], effect.unlocked_shows),
        }
        return {bit: real if shows is None else shows for bit, (real, shows) in there.items()}

    def _shown(self, name: str, channel: str, kpa: float, at: int) -> Value:
        """Return the reading of a device's pressure sensor for a real pressure of ``kpa``."""
        effect = self.scenario.effects.get(name)
        if effect is None:
            return self._pa(channel, kpa, at)
        if effect.invalid:
            return None
        shown = self._pa(channel, kpa if effect.shows_kpa is None else effect.shows_kpa, at)
        if self._is_over(effect.frozen_after_us, at):
            return self._frozen.setdefault(channel, shown)
        return shown

    def _swap(self, values: dict[str, Value]) -> None:
        channels = [actuator.channel for _, actuator in self._description.ordered]
        for index, name in enumerate(self._description.sequence):
            if self.scenario.effect(name).swapped:
                one, other = channels[index], channels[(index + 1) % len(channels)]
                values[one], values[other] = values.get(other), values.get(one)

    def _advance(self, at: int) -> None:
        """Advance time to ``at``, and apply losses that are due on the way."""
        while due := [s for s in self._driven if s.due is not None and s.due <= at]:
            station = min(due, key=lambda each: each.due or 0)
            self._plant.advance(station.due or 0)
            station.lose()
        self._plant.advance(at)

    def _pa(self, channel: str, kpa: float, at: int) -> int:
        noise = NOISE_QUANTITY if channel in self._quantities else NOISE_KPA
        return round((kpa + noise * self._noise.normal(channel, at - self._start)) * 1000)

    def _parsed(self, scenario: Scenario | str) -> Scenario:
        return parse_scenario(scenario, self._description) if isinstance(scenario, str) else scenario

    def _supply_kpa(self) -> float:
        kpa = self.scenario.supply_kpa
        return self._description.supply.nominal_kpa if kpa is None else kpa
