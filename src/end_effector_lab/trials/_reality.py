"""The real state of the devices, independent of sensors and program, since when it has lasted; and the arbiters."""

from __future__ import annotations

from collections.abc import Iterator

from end_effector_hal.arbiter import HAL, SENSOR_FAULT
from end_effector_hal.codecs import carrier_of
from end_effector_hal.control import Answer
from end_effector_hal.description import Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.signals import Kind
from end_effector_hal.vocabulary import ChangerFault, ChangerState, to_us
from end_effector_lab.testbench import TOOL_CHANGER
from end_effector_lab.virtual import VirtualTool

from ._effects import LYING

SEEN_US = 1_500_000
"""Time after which a fact has been read, filtered and reported, µs: a link counts as down after 1 s."""
BELIEVED_US = 1_000_000
"""Time after the end of a false reading for which it may still be believed, µs: filters, and readings that are not
stale yet.
"""
NOISE_KPA, FRAMES_US = 1.0, 100_000
"""Largest difference between a reading and the real value, kPa, and its longest duration, µs."""
NOT_KNOWN = frozenset({*LYING, "locked-shows", "unlocked-shows", "invalid", "reboot-after", "babble-after"})
_LOOSE = {
    "unlocked": "the tool is not locked", "absent": "there is no tool", "fault": "the tool changer is in FAULT",
}  # fmt: skip


class Reality:
    """Observes the simulated devices of a tool; `look` is called at each instant at which something happens."""

    def __init__(self, description: Description, tool: VirtualTool) -> None:
        self._description, self._tool = description, tool
        self._faults: frozenset[str] = frozenset()
        self._carried = carried = carrier_of(description).channels
        actuators = description.ordered
        self._by_pressure = {
            name for name, actuator in actuators if carried.get(actuator.channel) is Kind.PRESSURE
        }
        self._by_conditions = {name for name, actuator in actuators if kind_of(actuator).conditions(actuator)}
        self._opens_kpa = {
            name: kpa
            for name, actuator in actuators
            if carried.get(actuator.channel) is Kind.BIT
            and (kpa := kind_of(actuator).limits(actuator, description.supply).get("confirmed_kpa"))
            is not None
        }
        self._reads_air = description.supply.channel in carried
        self._has_wires = any(channel.digital for channel in description.channels.values())
        self._has_gripped = set[str]()
        self._lied_at = self._silent_at = -SEEN_US
        # it has been at rest for a while
        self._since = {what: tool.at - SEEN_US for what, so in self._found().items() if so}

    def suffers(self, scenario: str) -> None:
        """Process a new scenario of the testbench."""
        self._note_lies()
        self._faults = frozenset(part.strip() for part in scenario.split(","))
        self._note_lies()

    def look(self) -> None:
        """Record since when each fact has been true."""
        self._note_lies()
        links = self._description.links
        unasked = (
            self._description.register_outputs and "arbiter" not in self._tool.living
        )  # who masters the bus
        if unasked or any(self._tool.bench.silent(self._tool.at, name) for name in links):
            self._silent_at = self._tool.at
        for name in self._description.sequence:
            device = self._tool.bench.devices[name]
            if device.grips:
                self._has_gripped.add(name)
            elif device.is_released:
                self._has_gripped.discard(name)
        for what, so in self._found().items():
            if not so:
                self._since.pop(what, None)
            else:
                self._since.setdefault(what, self._tool.at)

    def lasts(self, what: str, us: int = SEEN_US) -> bool:
        """Return whether a fact has been true long enough, by default until the program has detected it."""
        return self._tool.at - self._since.get(what, self._tool.at) > us

    def lets_go(self, name: str) -> bool:
        """Return whether the device may release without this product: it receives nothing (`on_link_loss`), or another
        client commands it.
        """
        output, tool = self._description.actuators[name].modbus, self._tool
        if self.is_overruled(name):
            return True
        if output is None or output.on_link_loss != "release" or output.keep_alive_ms is None:
            return False
        silent = "arbiter" not in tool.living or tool.bench.silent(tool.at, output.link)
        return silent or not self.is_known

    def is_overruled(self, name: str) -> bool:
        """Return whether another client has made the output inactive, or will."""
        output = self._description.actuators[name].modbus
        return output is not None and self._tool.bench.foreign_write_at(output.link or None) is not None

    def waits_for_a_drop(self, name: str, since: int) -> bool:
        """Return whether the device of an output that became active at ``since`` µs has restarted: it then obeys only
        after its activation, which moves it, and which no last will begins.
        """
        output, tool = self._description.actuators[name].modbus, self._tool
        if output is None or output.activation is None:
            return False
        return tool.bench.booted(tool.at, output.link or None) > since

    def restarted(self, name: str, at: int) -> bool:
        """Return whether the device of an output restarted at ``at`` (µs): it then switches all outputs by itself."""
        output = self._description.actuators[name].modbus
        return output is not None and self._tool.bench.restarts_at(output.link or None) == at

    @property
    def is_known(self) -> bool:
        """Whether no sensor lies, now or shortly before."""
        return self._tool.at - self._lied_at > BELIEVED_US

    @property
    def is_read(self) -> bool:
        """Whether no sensor lies and no link is silent, now or shortly before."""
        return self.is_known and self._tool.at - self._silent_at > SEEN_US

    def grips(self, name: str) -> bool:
        """Return whether a device really grips, by its switch or by the thresholds for its pressure."""
        return self._tool.bench.devices[name].grips or self._is_over(name, "lost_kpa", 0.0)

    def surely_grips(self, name: str) -> bool:
        """Return whether a device grips, as in `grips`, even if noise opens its pressure switch."""
        opens_kpa = self._opens_kpa.get(name)
        kpa = self._tool.bench.devices[name].pressure_kpa
        return self.grips(name) and (opens_kpa is None or kpa is None or abs(kpa) > opens_kpa + NOISE_KPA)

    def closes(self, name: str) -> bool:
        """Return whether a device has lost its part, which its switch shows only at the end of the stroke."""
        device = self._tool.bench.devices[name]
        return (
            name in self._has_gripped
            and bool(device.empty_bit)
            and not (device.is_empty or device.is_released)
        )

    def against_a_grip(self) -> Iterator[str]:
        """Yield clauses why no grip may begin now."""
        rules, supply = self._description.interlocks, self._description.supply
        if self.lasts("silent"):
            yield "the link is silent (IL-07)"
        if not self.is_known:
            return
        if rules.il_07:
            for name in self._description.sequence:
                if self.lasts(f"grips {name}"):
                    yield f"{name} still grips (IL-07)"
        if rules.il_06 and self.lasts("low"):
            yield f"the air has less than {supply.refuse_kpa:g} kPa (IL-06)"
        yield from self._loose()

    def against_a_lift(self) -> Iterator[str]:
        """Yield clauses why the held part may not be lifted."""
        if self.lasts("silent"):
            yield "the link is silent"
        if self.is_known:
            yield from self._loose()

    def _loose(self) -> Iterator[str]:
        """Yield clauses about the tool that violate IL-05."""
        if self._description.interlocks.il_05:
            for what, clause in _LOOSE.items():
                if self.lasts(what):
                    yield f"{clause} (IL-05)"

    def against_an_unlock(self) -> Iterator[str]:
        """Yield clauses why the unlock output may not become active now."""
        rules, changer = self._description.interlocks, self._description.tool_changer
        if changer is None:
            return
        if rules.il_01 and self.is_known and not self.lasts("vented", to_us(changer.vented_s) - FRAMES_US):
            yield f"a vacuum was not under {changer.vented_kpa:g} kPa for {changer.vented_s:g} s (IL-01)"
        if rules.il_02 and self.lasts("away"):
            yield "the sensor of the stand says that the tool is not in it (IL-02)"

    def _found(self) -> dict[str, bool]:
        tool, supply, changer = self._tool, self._description.supply, self._description.tool_changer
        scenario, devices = tool.bench.scenario, tool.bench.devices
        found = dict[str, bool]()
        for name in self._description.sequence:
            found[f"grips {name}"] = grips = self.grips(name)
            found[f"gone {name}"] = not grips
            found[f"left {name}"] = self._is_left(name)
        kpa = scenario.supply_kpa
        found["low"] = self._reads_air and kpa is not None and kpa < supply.refuse_kpa - supply.hysteresis_kpa
        found["estop"] = self._description.e_stop is not None and not scenario.estop_ok
        found["silent"] = bool(self._description.links) and all(
            tool.bench.silent(tool.at, name) for name in self._description.links
        )
        if changer is not None:
            found["absent"] = not scenario.tool_present and changer.present_bit in self._carried
            found["fault"] = HAL in tool.living and tool.statuses[-1].changer is ChangerState.FAULT
            found["unlocked"] = not devices[TOOL_CHANGER].bits["locked"]
            found["vented"] = all(
                abs(devices[name].pressure_kpa or 0.0) < changer.vented_kpa + NOISE_KPA
                for name, actuator in self._description.ordered
                if name in self._by_pressure and kind_of(actuator).below_ambient
            )
            found["away"] = not {"not-in-stand", f"stand-shows:{TOOL_CHANGER}:0"}.isdisjoint(self._faults)
            told = HAL in tool.living and tool.statuses[-1].changer_fault == ChangerFault.SENSOR
            found["sensor fault"] = told and "arbiter" in tool.living
        return found

    def _is_left(self, name: str) -> bool:
        """Return whether a device is not completely released, by the thresholds of the description."""
        over = name not in self._by_conditions and self._is_over(name, "gone_kpa", NOISE_KPA)
        return over or self._tool.bench.devices[name].grips

    def _is_over(self, name: str, limit: str, margin_kpa: float) -> bool:
        """Return whether a pressure with a sensor is above a threshold of the description."""
        tool = self._description.for_part(self._tool.statuses[-1].part)
        device, actuator = self._tool.bench.devices[name], tool.actuators[name]
        kpa = kind_of(actuator).limits(actuator, self._description.supply).get(limit)
        if name not in self._by_pressure or kpa is None or device.pressure_kpa is None:
            return False
        return abs(device.pressure_kpa) > kpa + margin_kpa

    def _note_lies(self) -> None:
        at = self._tool.at
        stays = self._has_wires and self._tool.bench.silent(at)  # a wire that falls silent stays as it is
        if stays or any(fault.partition(":")[0] in NOT_KNOWN for fault in self._faults):
            self._lied_at = at


HEARD_US = 1_000_000
"""Time within which the program reports its wishes to a restarted arbiter, µs."""


class JudgedArbiter:
    """The successive line arbiters of a tool, as the judge sees them.

    Attributes:
        since: start of the present or last arbiter, µs.
        until: end of the last arbiter that has ended, µs.
    """

    def __init__(self, tool: VirtualTool, reality: Reality) -> None:
        self._tool, self._reality = tool, reality
        self._life: int | None = tool.arbiters
        self.since = self.until = tool.at
        self._latched: set[str] = set()
        self._sensor_fault = False
        self._changer_is_reset = False

    # When it lives

    @property
    def lives(self) -> bool:
        """Whether an arbiter is running now."""
        return "arbiter" in self._tool.living

    def look(self) -> tuple[bool, bool]:
        """Return whether an arbiter has ended, and whether one has started, since the last call."""
        before, self._life = self._life, self._tool.arbiters if self.lives else None
        if self._life == before:
            return False, False
        if before is not None:
            self.until = self._tool.at
        if self._life is not None:
            self.since = self._tool.at
        return before is not None, self._life is not None

    def has_lived_since(self, at: int) -> bool:
        """Return whether the arbiter has lived since ``at`` (µs); otherwise lines may be switched later than
        requested.
        """
        return self.lives and self.since <= at

    def has_heard_of(self, release: int) -> bool:
        """Return whether the arbiter has received the last will of a release of that time (µs); otherwise it has the
        previous one.
        """
        until = self._tool.at if self.lives else self.until
        if self.since <= release and (self.lives or release < until):
            return True
        return until - max(self.since, release) > HEARD_US

    # What it has latched

    def reset(self, answer: Answer) -> None:
        """Process a reset; a refused one clears everything except the persisting faults."""
        self._latched = set(self._tool.latched)
        if answer.accepted or (answer.decided and HAL not in self._tool.living):
            self._sensor_fault, self._changer_is_reset = False, True

    def forget(self) -> None:
        """Process a loss of the arbiter's data."""
        self._latched, self._sensor_fault = set(), False

    def unlatched(self) -> Iterator[str]:
        """Yield a sentence about every fault that is no longer latched although no reset was given."""
        tool, latched = self._tool, set(self._tool.latched)
        if tool.statuses[-1].changer_fault == ChangerFault.SENSOR:
            self._changer_is_reset = False
        again = {
            f"output {line}" for line, active in tool.levels.items() if active
        }  # activated since, as commanded
        gone = self._latched - latched - again - ({SENSOR_FAULT} if self._changer_is_reset else set())
        if gone:
            yield f"{', '.join(sorted(gone))} is latched no more, without a reset"
        self._latched = latched
        self._sensor_fault = self._sensor_fault or self._reality.lasts("sensor fault")
        changer = tool.statuses[-1].changer if HAL in tool.living else ChangerState.UNKNOWN
        if self._sensor_fault and changer in (ChangerState.LOCKED, ChangerState.UNLOCKED):
            yield f"the tool changer is {changer.name} after a sensor fault, without a reset (IL-04)"
