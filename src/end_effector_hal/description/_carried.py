"""What comes over the link, and what a description says of it that cannot be meant."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from ._actuators import Actuator, CylinderActuator
from ._devices import Supply
from ._fault import Fault, did_you_mean
from ._model import Description
from ._part import NO_CHANNEL
from ._units import number
from ._uses import BITS_BY_DEFAULT, uses

FROZEN_SAMPLES = 5


@dataclass(frozen=True)
class Carried:
    """What comes over the link.

    Attributes:
        codec: its name.
        channels: ``"pressure"`` or ``"bit"`` by name.
        period_us: nominal time between two frames.
        noise_shows: whether it counts finely enough to tell a frozen sensor from a living one.
    """

    codec: str
    channels: Mapping[str, str]
    period_us: int
    noise_shows: bool = True

    def of(self, kind: str) -> tuple[str, ...]:
        """Channels of a kind, in the order of the codec."""
        return tuple(name for name, each in self.channels.items() if each == kind)


def position_bits(description: Description) -> frozenset[str]:
    """Bits that mean something else than that an actuator shows feedback."""
    return BITS_BY_DEFAULT | {use.channel for use in uses(description) if use.bit}


def can_be_confirmed(actuator: Actuator, carried: Carried) -> bool:
    """Whether anything that comes over the link could confirm an actuator."""
    bit = actuator.extended_bit if isinstance(actuator, CylinderActuator) else None
    return actuator.channel in carried.channels or bit in carried.channels


def provers(description: Description, carried: Carried, name: str) -> str:
    """For a sentence: what could prove an actuator and belongs to nobody else.

    A pressure; where the codec has none, a bit that says the same; of a cylinder also its position bit.
    """
    others = {use.channel for use in uses(description) if use.stanza != ("actuators", name)}
    actuator = description.actuators[name]
    channels, bits = carried.of("pressure"), carried.of("bit")
    if not channels and actuator.kind == "vacuum":
        channels = tuple(each for each in bits if each not in position_bits(description))
    free = [each for each in channels if each not in others]
    said = [f"a free channel of {carried.codec}: {', '.join(free)}"] if free else []
    extended = str(CylinderActuator.model_fields["extended_bit"].default)
    if actuator.kind == "cylinder" and extended in bits and extended not in others:
        said.append(f"extended_bit: {extended}")
    none = f"another codec: {carried.codec} carries nothing more for a {actuator.kind}"
    return " or ".join(said) or none


def unwired(description: Description, carried: Carried) -> Iterator[Fault]:
    """Channels that are asked for and not carried: without them a proof or an interlock is off in silence.

    An actuator that nothing could confirm is told elsewhere, once.
    """
    unproven = {
        ("actuators", name) for name, each in description.ordered if not can_be_confirmed(each, carried)
    }
    for use in uses(description):
        told = not use.bit and use.stanza in unproven
        if told or use.channel in carried.channels:
            continue
        kind = "bit" if use.bit else "pressure"
        known = carried.of(kind)
        expected = (
            f"a {kind} of {carried.codec}: {', '.join(known)}" if known else f"a codec with such a {kind}"
        )
        meant = did_you_mean(use.channel, known) if use.written else ""
        yield Fault.at(
            description.place(*use.stanza, use.key),
            "EE-225",
            f"{carried.codec} carries no {use.channel!r}",
            found=None if use.written else f"{use.key}: {use.channel} (default)",
            expected=expected,
            hint=f"{f'{meant} ' if meant else ''}if there is no such sensor, write {use.key}: {NO_CHANNEL}",
        )


def no_bits(description: Description, carried: Carried) -> Iterator[Fault]:
    """Pressures where something that says yes or no is named."""
    for use in uses(description):
        if use.bit and carried.channels.get(use.channel) == "pressure":
            place, found = description.place(*use.stanza, use.key), f"{use.key}: {use.channel}"
            yield Fault.at(place, "EE-225", f"{use.channel!r} is a pressure", found=found, expected="a bit")


def too_soon(description: Description, carried: Carried) -> Iterator[Fault]:
    """A living sensor may show the same twice: to be frozen takes some samples."""
    least_s = FROZEN_SAMPLES * carried.period_us / 1e6
    parts: list[tuple[tuple[str, ...], Actuator | Supply]] = [(("supply",), description.supply)]
    parts += [(("actuators", name), each) for name, each in description.ordered]
    for stanza, part in parts:
        watched = carried.noise_shows and carried.channels.get(part.channel) == "pressure"
        if watched and part.frozen_s is not None and part.frozen_s < least_s:
            what = f"a living sensor would be taken for a frozen one: {FROZEN_SAMPLES} samples take"
            yield Fault.at(
                description.place(*stanza, "frozen_s"),
                "EE-225",
                f"{what} {number(least_s)} s with {carried.codec}",
                expected=f"at least {number(least_s)}, or null",
            )
