"""The channels that a description names, those that the link carries, and faults in their use."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from end_effector_hal.description._fault import Fault, did_you_mean
from end_effector_hal.description._numbers import number
from end_effector_hal.description.model._description import Description
from end_effector_hal.description.model._stanzas import EStop, ToolChanger
from end_effector_hal.kinds import kind_of, usable_kinds
from end_effector_hal.kinds.stanza import NO_CHANNEL, Actuator, BaseStanza, Supply
from end_effector_hal.signals import Kind


@dataclass(frozen=True)
class Use:
    """A use of a channel by a key; ``bit``: the channel is a bit, else it is a pressure.

    ``condition``: the use is in the evidence that an actuator declares, with these thresholds (key and gauge kPa).
    """

    stanza: tuple[str | int, ...]
    key: str
    channel: str
    bit: bool
    written: bool
    condition: bool = False
    thresholds: tuple[tuple[str, float], ...] = ()


def used_channels(description: Description) -> tuple[str, ...]:
    """Return the names of the channels that a description needs, without repetition.

    The order is: actuators in the sequence, other devices, supply.

    Other channels of a link do not matter to this tool.
    """
    return tuple(dict.fromkeys(use.channel for each in description.per_part for use in uses(each)))


def uses(description: Description) -> Iterator[Use]:
    """Yield every channel that a description needs, defaults included, but no `NO_CHANNEL`."""
    for name, each in description.ordered:
        for asked in kind_of(each).channels:
            # what evidence replaces is not asked for by default
            if each.evidence is None or asked.key in each.model_fields_set:
                yield from _of(("actuators", name), each, asked.key, bit=asked.carries is Kind.BIT)
        for leaf in each.evidence.leaves if each.evidence else ():
            where = ("actuators", name, "evidence", *leaf.path)
            yield Use(where, leaf.key, leaf.channel, leaf.bit, True, True, leaf.thresholds)
    if description.tool_changer:
        for key in ToolChanger.BITS:
            yield from _of(("tool_changer",), description.tool_changer, key, bit=True)
    if description.e_stop:
        yield from _of(("e_stop",), description.e_stop, "channel", bit=True)
    yield from _of(("supply",), description.supply, "channel", bit=False)
    for name, channel in description.channels.items():
        if channel.alarm and channel.unit is None:
            yield Use(("channels", name), "alarm", name, bit=True, written=True)


def _of(path: tuple[str | int, ...], stanza: BaseStanza, key: str, *, bit: bool) -> Iterator[Use]:
    channel = getattr(stanza, key)
    if channel and channel != NO_CHANNEL:
        yield Use(path, key, channel, bit, key in stanza.model_fields_set)


def bits_by_default() -> frozenset[str]:
    """Return the default names of bits of all devices, whether this tool has the device or not."""
    keyed: list[tuple[type[BaseStanza], tuple[str, ...]]] = [
        (ToolChanger, ToolChanger.BITS),
        (EStop, ("channel",)),
    ]
    keyed += [
        (kind.stanza, tuple(each.key for each in kind.channels if each.carries is Kind.BIT))
        for kind in usable_kinds().values()
    ]
    defaults = (model.model_fields[key].default for model, keys in keyed for key in keys)
    return frozenset(name for name in defaults if isinstance(name, str))


FROZEN_SAMPLES = 5


@dataclass(frozen=True)
class CodecChannels:
    """The channels that come over the links and from the inputs of the board.

    Attributes:
        codec: name of their source, for sentences.
        channels: type of each channel, by name.
        period_us: nominal time between two frames of the slowest source, µs.
        stale_s: time for which a reading is valid, s; that of the source with the longest.
        noise_shows: whether the values are fine enough to distinguish a frozen sensor from a working one.
        declared: whether no codec is named, so that a missing channel must be declared under `channels`.
        faulty: channels whose declaration has a fault; that they are not carried is only a consequence.
    """

    codec: str
    channels: Mapping[str, Kind]
    period_us: int
    stale_s: float
    noise_shows: bool = True
    declared: bool = False
    faulty: frozenset[str] = frozenset()

    def of(self, kind: Kind) -> tuple[str, ...]:
        """Return the channels of this type, in the order of the codec."""
        return tuple(name for name, each in self.channels.items() if each is kind)


def position_bits(description: Description) -> frozenset[str]:
    """Return the bits that have another meaning than the feedback of an actuator."""
    return bits_by_default() | {use.channel for use in uses(description) if use.bit}


def can_be_confirmed(actuator: Actuator, codec: CodecChannels) -> bool:
    """Return whether any channel of the link could confirm an actuator."""
    return kind_of(actuator).can_confirm(actuator, codec.channels)


def provers(description: Description, codec: CodecChannels, name: str) -> str:
    """Return for a sentence the channels that could prove an actuator and are free.

    These are a pressure if the kind has one, else a bit with the same meaning; and its position bits.
    """
    others = {use.channel for use in uses(description) if use.stanza[:2] != ("actuators", name)}
    kind, bits, said = kind_of(description.actuators[name]), codec.of(Kind.BIT), []
    for each in kind.channels:
        if each.confirms and each.carries is Kind.BIT:
            usual = str(kind.stanza.model_fields[each.key].default)
            said += [f"{each.key}: {usual}"] if usual in bits and usual not in others else []
        elif each.confirms:
            channels = codec.of(Kind.PRESSURE)
            if each.bit_instead and (codec.declared or not channels):
                channels += tuple(bit for bit in bits if bit not in position_bits(description))
            if free := [channel for channel in channels if channel not in others]:
                said.append(f"a free channel of {codec.codec}: {', '.join(free)}")
    more = "another one under channels" if codec.declared else "another codec"
    return " or ".join(said) or f"{more}: {codec.codec} has no free channel for a {kind.name}"


def unwired(description: Description, codec: CodecChannels) -> Iterator[Fault]:
    """Yield a fault for each channel that is needed and not carried.

    Without it a proof or an interlock would be off silently.

    An actuator that nothing could confirm is reported elsewhere, once.
    """
    unproven = {
        ("actuators", name) for name, each in description.ordered if not can_be_confirmed(each, codec)
    }
    for use in uses(description):
        told = not use.bit and not use.condition and use.stanza in unproven
        if told or use.channel in codec.channels or use.channel in codec.faulty:
            continue
        quantity = any(key in _OF_QUANTITIES for key, _ in use.thresholds)
        kind = Kind.BIT if use.bit else Kind.QUANTITY if quantity else Kind.PRESSURE
        known = codec.of(kind)
        if known:
            expected = f"a {kind.value} of {codec.codec}: {', '.join(known)}"
        elif codec.declared:
            expected = f"such a {kind.value} under channels"
        else:
            expected = f"a codec with such a {kind.value}"
        place = description.place(*use.stanza, use.key)
        absent = f"{use.key}: {NO_CHANNEL}"
        if use.stanza[0] not in description.model_fields_set:  # only what does not carry it is written
            carrier = description.key_place("channels" if codec.declared else "link")
            place, absent = replace(carrier, path=place.path), f"{use.stanza[0]}: {{{absent}}}"
        meant = did_you_mean(use.channel, known) if use.written else ""
        instead = "" if use.condition else f"if there is no such sensor, write {absent}"
        yield Fault.at(
            place,
            "EE-225",
            f"{codec.codec} carries no {use.channel!r}",
            found=None if use.written else f"{use.key}: {use.channel} (default)",
            expected=expected,
            hint=" ".join(filter(None, (meant, instead))),
        )


def no_bits(description: Description, codec: CodecChannels) -> Iterator[Fault]:
    """Yield a fault for each bit key that names a measured channel.

    Also yield one for each pressure key that names a quantity.
    """
    for use in uses(description):
        carries, place = codec.channels.get(use.channel), description.place(*use.stanza, use.key)
        if use.bit and (
            carries in (Kind.PRESSURE, Kind.QUANTITY) or (carries is Kind.CODE and use.key != "alarm")
        ):
            what, found = f"{use.channel!r} is a {carries.value}", f"{use.key}: {use.channel}"
            yield Fault.at(place, "EE-225", what, found=found, expected="a bit")
        elif use.condition and not use.bit and carries is Kind.BIT:
            hint = f"write {{on: {use.channel}}}"
            yield Fault.at(place, "EE-225", f"{use.channel!r} is a bit", expected="a pressure", hint=hint)
        elif not use.bit and carries is Kind.QUANTITY and not use.condition:
            what = f"{use.channel!r} is measured in {description.channels[use.channel].unit}"
            hint = "conditions under `evidence` can look at it" if use.stanza[0] == "actuators" else ""
            yield Fault.at(place, "EE-225", what, expected="a pressure", hint=hint)
        elif use.condition and not use.bit:
            yield from _wrong_thresholds(description, use, carries)


_OF_QUANTITIES = ("below", "above", "between")


def _wrong_thresholds(description: Description, use: Use, carries: Kind | None) -> Iterator[Fault]:
    """Check that thresholds of a pressure are in kPa, and others in the unit of their channel."""
    for key in dict.fromkeys(key for key, _ in use.thresholds):
        place = description.place(*use.stanza, key)
        if carries is Kind.QUANTITY and key not in _OF_QUANTITIES:
            unit = description.channels[use.channel].unit
            what, expected = (
                f"{use.channel!r} is measured in {unit}",
                f"{key.removesuffix('_kpa')}: …, in {unit}",
            )
            yield Fault.at(place, "EE-225", what, found=key, expected=expected)
        elif carries is Kind.PRESSURE and key in _OF_QUANTITIES:
            what, expected = f"{use.channel!r} is a pressure", f"{key}_kpa: …, gauge kPa"
            yield Fault.at(place, "EE-225", what, found=key, expected=expected)


def impossible_thresholds(description: Description) -> Iterator[Fault]:
    """Yield a fault for each threshold that the pressure of an actuator can never pass."""
    for use in uses(description):
        actuator = description.actuators[str(use.stanza[1])] if use.condition else None
        if actuator is None or use.channel != actuator.channel:
            continue
        span = kind_of(actuator).plausible(actuator)
        for key, kpa in use.thresholds:
            if not span.has(round(kpa * 1000)):
                below = kpa > 0 and span.has(round(-kpa * 1000))
                hint = f"gauge pressure below ambient is negative here; write {key}: {number(-kpa)}"
                yield Fault.at(
                    description.place(*use.stanza, key),
                    "EE-227",
                    f"{span.what} cannot have {number(kpa)} kPa",
                    expected=f"{number(span.low)} to {number(span.high)} kPa gauge",
                    hint=hint if below and key != "between_kpa" else "",
                )


def too_soon(description: Description, codec: CodecChannels) -> Iterator[Fault]:
    """Yield a fault for each `frozen_s` that is too short: a working sensor may repeat a value."""
    least_s = FROZEN_SAMPLES * codec.period_us / 1e6
    stanzas: list[tuple[tuple[str, ...], Actuator | Supply]] = [(("supply",), description.supply)]
    stanzas += [(("actuators", name), each) for name, each in description.ordered]
    for path, stanza in stanzas:
        watched = codec.noise_shows and codec.channels.get(stanza.channel) is Kind.PRESSURE
        if watched and stanza.frozen_s is not None and stanza.frozen_s < least_s:
            what = f"a working sensor would count as frozen: {FROZEN_SAMPLES} samples take"
            yield Fault.at(
                description.place(*path, "frozen_s"),
                "EE-225",
                f"{what} {number(least_s)} s with {codec.codec}",
                expected=f"at least {number(least_s)}, or null",
            )
