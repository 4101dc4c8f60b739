"""Scenarios as data: the faults that a scenario can name, one per row, and the parser for its text."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from difflib import get_close_matches
from typing import Any, Literal

from end_effector_hal.codecs import codec_of, is_polled
from end_effector_hal.description import Description, network_address
from end_effector_hal.errors import UsageError
from end_effector_hal.faults import FaultNumber
from end_effector_hal.kinds import kind_of
from end_effector_hal.kinds.stanza import Actuator, named
from end_effector_hal.signals import Kind

from .physics import ACTUATOR, CHANGER, LEAKS, PARTS, PRESSURE, STICKS, Device, ToolChanger, physics_of

NEVER = 10**9


@dataclass(frozen=True)
class Effect:
    """The faults of one device; `FAULTS` explains them. Times count from the choice of the scenario."""

    dead_activations: int = 0
    stuck: bool = False
    leak_l_min: float = 0.0
    """Leak at 60 kPa of vacuum, l/min."""
    leak_grows_l_min_s: float = 0.0
    no_part: bool = False
    sticks: bool = False
    lost_after_us: int | None = None
    """Time of the loss after the activation, µs; the line stays active."""
    invalid: bool = False
    shows_kpa: float | None = None
    frozen_after_us: int | None = None
    swapped: bool = False
    locked_shows: bool | None = None
    unlocked_shows: bool | None = None
    stand_shows: bool | None = None


_NO_EFFECT = Effect()


@dataclass(frozen=True, kw_only=True)
class LinkEffect:
    """The faults of a sensor link, or of the sending device; `FAULTS` explains them. Shares are from 0 to 1."""

    silent_after_us: int | None = None
    babble_after_us: int | None = None
    reboot_after_us: int | None = None
    noise: float = 0.0
    flips: float = 0.0
    bursts: float = 0.0
    dropped: float = 0.0
    doubled: float = 0.0
    late_us: int = 0
    """Delay of every answer of a polled device, µs; the next three fields are shares of its answers."""
    unanswered: float = 0.0
    twice: float = 0.0
    another: float = 0.0
    closed_after_us: int | None = None
    cut: float = 0.0
    """Share of the answers of a device at an address after whose first half the connection is reset."""
    foreign_write_after_us: int | None = None
    other_device_after_us: int | None = None

    @property
    def disturbs(self) -> bool:
        """Whether bytes are changed at random on the link."""
        return bool(self.noise or self.flips or self.bursts or self.dropped or self.doubled)

    @property
    def misanswers(self) -> bool:
        """Whether a polled device sends wrong answers at random."""
        return bool(self.unanswered or self.twice or self.another)


@dataclass(frozen=True)
class Scenario(LinkEffect):
    """The faults of a whole bench, parsed by `parse_scenario`. Faults of all links are its own fields."""

    text: str = "nominal"
    effects: Mapping[str, Effect] = field(default_factory=dict)
    links: Mapping[str, LinkEffect] = field(default_factory=dict)
    """Links with faults of their own, by name."""
    supply_kpa: float | None = None
    """Regulated supply pressure, kPa; None: the nominal one of the description."""
    tool_present: bool = True
    in_stand: bool = True
    estop_ok: bool = True
    alarms: Mapping[str, int] = field(default_factory=dict)
    """Values of alarm channels: a code, or 1 for a bit."""

    def effect(self, device: str) -> Effect:
        return self.effects.get(device, _NO_EFFECT)

    def on_link(self, name: str | None) -> LinkEffect:
        """Return the faults of a link by its name; for None, those of the inputs of the board."""
        return self.links.get(name or "", self)


ANY = ACTUATOR, CHANGER
_MICROS = {"seconds": 1_000_000, "ms": 1_000}


@dataclass(frozen=True)
class Fault:
    """A kind of fault.

    Args:
        name: its name in a scenario, ``name[:actuator][:number]``.
        meaning: a phrase for people.
        sets: the field of :class:`Effect`, or of :class:`Scenario`, that it sets; empty: none.
        on: traits of devices; the fault needs a device with one of them; empty: it concerns the whole bench.
        number: the number that must be given.
        link: a sensor link can have it ("also"), only a link can ("only"), only a polled link ("polled"),
            only one that asks Modbus registers ("modbus"), only one with outputs ("commanded"), or only one that asks
            a device at an address ("network").
        channel: it concerns a channel that is an alarm.
        value: the value of the field, where no number gives it.
    """

    name: str
    meaning: str
    sets: str
    on: tuple[str, ...] = ()
    number: FaultNumber | None = None
    link: Literal["", "also", "only", "polled", "modbus", "commanded", "network"] = ""
    channel: bool = False
    value: object = True

    def changes(self, number: float) -> Iterator[tuple[str, object]]:
        """Yield the field that it sets, with its value; ``number``: of its text. Times become µs, a bit a bool."""
        value, of = self.value, self.number
        if of is BIT:
            value = bool(number)
        elif of is not None:
            found = number * _MICROS.get(of.name, 1)
            value = round(found) if of.whole or of.name in _MICROS else found
        if self.sets:
            yield self.sets, value

    @property
    def usage(self) -> str:
        """The syntax of the fault, such as ``leak:<actuator>[:<l_min>]``."""
        text = self.name + (
            ":<actuator>" if self.on else ":<channel>" if self.channel else "[:<link>]" if self.link else ""
        )
        if self.number is None:
            return text
        return text + (
            f"[:<{self.number.name}>]" if self.number.default is not None else f":<{self.number.name}>"
        )


ASKING = {"polled": "polled", "modbus": "Modbus", "commanded": "commanded", "network": "network"}
"""Links that ask, in words."""
RATE = FaultNumber("rate", 0, 1)
BIT = FaultNumber("bit", 0, 1, whole=True)
SECONDS = FaultNumber("seconds", 0, 86400)

FAULTS: tuple[Fault, ...] = (
    Fault("nominal", "nothing is wrong", ""),
    Fault("fails-once", "its first activation has no effect", "dead_activations", ANY, value=1),
    Fault("fails", "its first activations have no effect", "dead_activations", ANY,
          FaultNumber("times", 1, 1000, whole=True)),
    Fault("never-confirms", "no activation has any effect", "dead_activations", ANY, value=NEVER),
    Fault("stuck-release", "its feedback stays after the deactivation", "stuck", ANY),
    Fault("leak", "it leaks: confirmed, but never secure", "leak_l_min", (LEAKS,),
          FaultNumber("l_min", 0.1, 2000, default=4.0)),
    Fault("leak-grows", "its leak grows by this much per second: first weak, then lost", "leak_grows_l_min_s", (LEAKS,),
          FaultNumber("l_min_s", 0.01, 100, default=1.0)),
    Fault("lost-after", "its part is lost this long after the activation", "lost_after_us", (ACTUATOR,),
          FaultNumber("seconds", 0.001, 86400)),
    Fault("no-part", "there is nothing for it to grip", "no_part", (PARTS,)),
    Fault("sticks", "its part sticks to it until it is blown off", "sticks", (STICKS,)),
    Fault("invalid", "its pressure is marked as invalid", "invalid", (PRESSURE,)),
    Fault("shows", "its sensor shows this gauge pressure, in any case", "shows_kpa", (PRESSURE,),
          FaultNumber("kpa", -110, 800)),
    Fault("frozen-after", "its sensor keeps its value from then on", "frozen_after_us", (PRESSURE,), SECONDS),
    Fault("swapped", "its sensor is exchanged with the next actuator's", "swapped", (PRESSURE,)),
    Fault("locked-shows", "its sensor of locked always shows this bit", "locked_shows", (CHANGER,), BIT),
    Fault("unlocked-shows", "its sensor of unlocked always shows this bit", "unlocked_shows", (CHANGER,), BIT),
    Fault("stand-shows", "the sensor of the tool's stand shows this bit in any case", "stand_shows", (CHANGER,), BIT),
    Fault("supply", "the air supply has this gauge pressure", "supply_kpa", number=FaultNumber("kpa", 0, 2000)),
    Fault("silent-after", "the link falls silent, or the inputs of the board do", "silent_after_us",
          (), SECONDS, "also"),
    Fault("babble-after", "the link carries random bytes only", "babble_after_us", (), SECONDS, "only"),
    Fault("reboot-after", "the device that sends restarts", "reboot_after_us", (), SECONDS, "only"),
    Fault("noise", "this share of the bytes on the link is changed", "noise", (), RATE, "only"),
    Fault("flips", "this share of the bits on the link is turned over", "flips", (), RATE, "only"),
    Fault("bursts", "of this share of the frames some bytes in a row are changed", "bursts", (), RATE, "only"),
    Fault("lost-bytes", "this share of the bytes on the link is lost", "dropped", (), RATE, "only"),
    Fault("doubled-bytes", "this share of the bytes on the link comes twice", "doubled", (), RATE, "only"),
    Fault("late-answers", "a polled device answers this much later", "late_us", (),
          FaultNumber("ms", 1, 60_000, whole=True), "polled"),
    Fault("no-answers", "a polled device does not answer this share of the requests", "unanswered", (), RATE, "polled"),
    Fault("twice-answers", "this share of the answers of a polled device comes twice", "twice", (), RATE, "polled"),
    Fault("wrong-answers", "this share of the answers of a polled device comes from another one, undamaged", "another",
          (), RATE, "modbus"),
    Fault("closed-after", "the device at an address refuses connections, and has reset those it had", "closed_after_us",
          (), SECONDS, "network"),
    Fault("cut-answers", "this share of the answers ends in the middle, with a reset of the connection", "cut",
          (), RATE, "network"),
    Fault("foreign-write-after", "another client makes all outputs on the link inactive, once",
          "foreign_write_after_us", (), SECONDS, "commanded"),
    Fault("other-device-after", "another device answers there: its registers are 0, and its outputs move nothing",
          "other_device_after_us", (), SECONDS, "commanded"),
    Fault("no-tool", "no tool is present", "tool_present", value=False),
    Fault("not-in-stand", "the tool is away from its stand", "in_stand", value=False),
    Fault("estop-open", "the emergency stop is open", "estop_ok", value=False),
    Fault("alarm", "an alarm channel shows an alarm, or this code", "shows",
          number=FaultNumber("code", -(2**31), 2**31 - 1, default=1, whole=True), channel=True),
)  # fmt: skip


TOOL_CHANGER = "tool_changer"


def device_physics(description: Description) -> dict[str, type[Device]]:
    """Return the physics of every device that can have faults: ``tool_changer``, then the actuators."""
    changer: dict[str, type[Device]] = {TOOL_CHANGER: ToolChanger} if description.tool_changer else {}
    return changer | {name: physics_of(actuator.kind) for name, actuator in description.ordered}


def traits_of(description: Description) -> dict[str, frozenset[str]]:
    """Return the traits of the devices, which decide their faults; a device without a pressure channel
    lacks PRESSURE.
    """
    found = {name: physics.traits for name, physics in device_physics(description).items()}
    blind = [name for name, actuator in description.ordered if not _shows_pressure(actuator)]
    return found | {name: found[name] - {PRESSURE} for name in blind}


def _shows_pressure(actuator: Actuator) -> bool:
    asked = actuator.evidence
    keys = [
        key for key in kind_of(actuator).channels if asked is None or key.key in actuator.model_fields_set
    ]
    fitted = any(key.carries is not Kind.BIT and named(getattr(actuator, key.key)) for key in keys)
    return fitted or (asked is not None and any(not leaf.bit for leaf in asked.leaves))


def parse_scenario(text: str, description: Description) -> Scenario:
    """Parse a scenario: faults separated by commas, such as ``leak:top_vacuum,silent-after:5``.

    Raises:
        UsageError: an unknown fault or actuator, a number that is missing or out of range, a fault that the actuator
            cannot have, or two faults that contradict each other.
    """
    traits = traits_of(description)
    whole: dict[str, Any] = {}
    devices: dict[str, dict[str, Any]] = {}
    links: dict[str, dict[str, Any]] = {}
    alarms: dict[str, dict[str, Any]] = {}
    by: dict[tuple[int, str], str] = {}
    for part in (each.strip() for each in text.split(",")):
        fault, name, number = _read(part, traits, description)
        if fault.link not in ("", "also") and not description.links:
            raise UsageError(
                f"{part!r} is a fault of a sensor link, and {description.name} has none.",
                todo="Faults of its inputs: shows, frozen-after, invalid, silent-after.",
            )
        asking = links_with(fault, description)
        if name not in asking if fault.link and name else not asking and fault.link in ASKING:
            kind = ASKING[fault.link]
            raise UsageError(
                f"{part!r} is a fault of a {kind} link, and {name or description.name} is not {kind}."
            )
        named = links if fault.link else alarms if fault.channel else devices
        changed = named.setdefault(name, {}) if name else whole
        for key, value in fault.changes(number):
            if changed.get(key, value) != value:
                other = by[id(changed), key]
                raise UsageError(
                    f"scenario {text!r}: {part!r} contradicts {other!r}.", todo="Remove one of them."
                )
            changed[key], by[id(changed), key] = value, part
    effects = {device: replace(Effect(), **changed) for device, changed in devices.items()}
    shown = {channel: changed["shows"] for channel, changed in alarms.items()}
    every = replace(Scenario(text=text, effects=effects, alarms=shown), **whole)
    of_all = {each.name: getattr(every, each.name) for each in fields(LinkEffect)}
    return replace(every, links={name: LinkEffect(**of_all | changed) for name, changed in links.items()})


def links_with(fault: Fault, description: Description) -> list[str]:
    """Return the names of the links that can have a fault."""
    if fault.link not in ASKING:
        return [*description.links]
    if fault.link == "commanded":
        return [*description.buses]
    codecs = {name: codec_of(description, name) for name in description.links}
    asked = [name for name, codec in codecs.items() if is_polled(codec)]
    if fault.link == "network":
        return [name for name in asked if network_address(description.links[name].port)]
    return [name for name in asked if fault.link == "polled" or hasattr(codecs[name], "reads")]


def _read(
    part: str, traits: Mapping[str, frozenset[str]], description: Description
) -> tuple[Fault, str, float]:
    """Parse one part into fault, name of the device, link or channel (empty: none), and number (NaN: none)."""
    name, *values = part.split(":")
    fault = next((fault for fault in FAULTS if fault.name == name), None)
    if fault is None:
        raise UsageError(
            f"no fault is named {name!r}.", todo=did_you_mean(name, [fault.name for fault in FAULTS])
        )
    device = ""
    if fault.on:
        device = values.pop(0) if values else ""
        if device not in traits:
            what = f"{part!r}: no actuator is named {device!r}." if device else f"{part!r} names no actuator."
            raise UsageError(what, todo=did_you_mean(device, traits))
        if traits[device].isdisjoint(fault.on):
            able = [fault.name for fault in FAULTS if not traits[device].isdisjoint(fault.on)]
            raise UsageError(
                f"{part!r}: {device} cannot have this fault.", todo=f"It can have: {', '.join(able)}."
            )
    if fault.channel:
        channels = [each for each, channel in description.channels.items() if channel.alarm]
        if not channels:
            raise UsageError(f"{part!r}: {description.name} has no channel that is an alarm.")
        device = values.pop(0) if values else ""
        if device not in channels:
            what = f"no alarm is named {device!r}" if device else "it names no channel"
            raise UsageError(f"{part!r}: {what}.", todo=did_you_mean(device, channels))
    if (
        fault.link
        and values
        and values[0][:1].isalpha()
        and (device := values.pop(0)) not in (known := [*description.named_links])
    ):
        if not known:
            raise UsageError(f"{part!r} names a link, and the links of this tool have no names.")
        raise UsageError(f"{part!r}: no link is named {device!r}.", todo=did_you_mean(device, known))
    number = _number(part, values, fault.number) if fault.number else math.nan
    if values:
        raise UsageError(f"{part!r} has too many parts.", todo=f"Expected: {fault.usage}.")
    return fault, device, number


def _number(part: str, values: list[str], number: FaultNumber) -> float:
    if not values and number.default is not None:
        return number.default
    kind = "a whole number" if number.whole else "a number"
    expected = f"{kind} from {number.low:g} to {number.high:g}"
    if not values:
        raise UsageError(f"{part!r} needs a number.", todo=f"Expected: {number.name}, {expected}.")
    value = plain_number(values.pop(0))
    if value is None or not number.low <= value <= number.high or (number.whole and not value.is_integer()):
        raise UsageError(f"{part!r}: {number.name} must be {expected}.")
    return value


_PLAIN = re.compile(r"[+-]?(\d{1,40}(\.\d{0,40})?|\.\d{1,40})([eE][+-]?\d{1,3})?", re.ASCII)


def plain_number(text: str) -> float | None:
    """Parse a decimal number in ASCII; None for other texts that `float` accepts: ``nan``, ``1_0``, digits of other
    scripts.
    """
    return float(text) if _PLAIN.fullmatch(text) else None


def did_you_mean(wrong: str, right: Iterable[str]) -> str:
    """Return advice about an unknown name: the closest known one, or all of them."""
    names = list(right)
    close = get_close_matches(wrong, names, n=1, cutoff=0.5)
    return f"Did you mean {close[0]!r}?" if close else f"There are: {', '.join(names)}."
