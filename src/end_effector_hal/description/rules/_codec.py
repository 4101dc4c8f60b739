"""Compares the channels of a codec with the needs of a description, and finds what can never be proven.

Codecs belong to a higher layer; here a codec is only its period and its channels.
"""

from __future__ import annotations

from collections.abc import Iterator

from end_effector_hal.description._fault import Fault, did_you_mean
from end_effector_hal.description._numbers import number
from end_effector_hal.description.model._description import Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.kinds.stanza import Actuator, EvidenceConditions
from end_effector_hal.signals import Kind

from ._channels import (
    CodecChannels,
    can_be_confirmed,
    impossible_thresholds,
    no_bits,
    position_bits,
    provers,
    too_soon,
    unwired,
    uses,
)
from ._evidence import impossible_evidence, overlapping_evidence


def unproven(description: Description, codec: CodecChannels) -> list[Fault]:
    """Return a fault for each actuator that can never be confirmed over this link, in the order of the file.

    Also return one for each channel that is needed and not carried: it must not switch off a proof silently.
    """
    found = [
        fault for name, each in description.ordered for fault in _unproven(description, codec, name, each)
    ]
    named = [*unwired(description, codec), *no_bits(description, codec), *impossible_thresholds(description)]
    named += impossible_evidence(description, codec)
    return sorted([*found, *named, *too_soon(description, codec)])


def _unproven(
    description: Description, codec: CodecChannels, name: str, actuator: Actuator
) -> Iterator[Fault]:
    kind = kind_of(actuator)
    asked = {use.channel for use in uses(description) if use.stanza[:2] == ("actuators", name)}
    # what conditions ask for and nothing carries is told channel by channel
    told = bool(kind.conditions(actuator)) or not asked.isdisjoint(codec.faulty)
    if not told and not can_be_confirmed(actuator, codec):
        what = f"{codec.codec} carries nothing that could confirm {name!r}"
        proof = next(each for each in kind.channels if each.confirms)
        place = description.place("actuators", name, proof.key)
        meant = codec.of(proof.carries)
        if proof.bit_instead and (codec.declared or not meant):
            meant += codec.of(Kind.BIT)
        hint = did_you_mean(getattr(actuator, proof.key), meant)
        yield Fault.at(place, "EE-225", what, expected=provers(description, codec, name), hint=hint)
    e_stop = description.e_stop.channel if description.e_stop else ""  # told by the rules of ownership
    is_switch = codec.channels.get(actuator.channel) is Kind.BIT and actuator.channel != e_stop
    if is_switch and actuator.channel in position_bits(description):
        place = description.place("actuators", name, "channel")
        what = f"{actuator.channel!r} is a position bit and no pressure"
        yield Fault.at(place, "EE-225", what, expected=provers(description, codec, name))
    if conditions := kind.conditions(actuator):
        yield from _lasts_too_long(description, codec, name, conditions)
    elif kind.samples:
        samples = getattr(actuator, kind.samples)
        least_s = (samples - 1) * codec.period_us / 1e6
        if least_s >= actuator.timeout_s:
            place = description.place("actuators", name, kind.samples)
            what = f"{name!r} can never be confirmed: {samples} samples take {number(least_s)} s"
            expected = f"less than timeout_s = {number(actuator.timeout_s)}"
            yield Fault.at(place, "EE-225", what, found=codec.codec, expected=expected)


def _lasts_too_long(
    description: Description, codec: CodecChannels, name: str, conditions: EvidenceConditions
) -> Iterator[Fault]:
    """Yield a fault for each condition that takes longer than its time-out, so that it is never met."""
    actuator = description.actuators[name]
    for which, key, limit_s in (
        ("confirmed", "timeout_s", actuator.timeout_s), ("gone", "release_s", actuator.release_s)
    ):  # fmt: skip
        least_s = getattr(conditions, which).lasts_s(codec.period_us / 1e6)
        if least_s >= limit_s:
            own = actuator.evidence is not None
            place = description.place("actuators", name, *(("evidence", which) if own else (key,)))
            what = f"{name!r} can never be {which}: it takes {number(least_s)} s"
            yield Fault.at(
                place, "EE-225", what, found=codec.codec, expected=f"less than {key} = {number(limit_s)}"
            )


def not_fitted(description: Description, codec: CodecChannels) -> list[str]:
    """Return a sentence for each function that is off because the channel that it needs is not carried."""
    actuators = (sentence for name, each in description.ordered for sentence in _actuator(name, each, codec))
    return [*actuators, *_supply(description, codec), *_interlocks(description, codec)]


def _actuator(name: str, actuator: Actuator, codec: CodecChannels) -> Iterator[str]:
    carries = codec.channels.get(actuator.channel)
    if carries is Kind.BIT:
        yield f"{name}: {actuator.channel} is a switch, on or off, and no pressure: thresholds are off"
    if actuator.frozen_s is not None and carries is Kind.PRESSURE and not codec.noise_shows:
        yield f"{name}: {codec.codec} counts too coarsely to show a frozen sensor: frozen_s is off"
    if actuator.evidence is not None:
        return  # what its kind would prove does not count
    for phrase in kind_of(actuator).not_fitted(actuator, codec.channels):
        yield f"{name}: {phrase}"


def _supply(description: Description, codec: CodecChannels) -> Iterator[str]:
    supply = description.supply
    carries = codec.channels.get(supply.channel)
    if carries is Kind.BIT:
        yield f"supply: {supply.channel} is a switch, on or off, and no pressure: IL-06 has no thresholds"
    elif carries is None:
        assumed = f"{number(supply.nominal_kpa)} kPa is assumed, and low pressure is not detected"
        yield f"no sensor of the supply (channel: {supply.channel}): IL-06 is off: {assumed}"


def _interlocks(description: Description, codec: CodecChannels) -> Iterator[str]:
    channels, changer, e_stop = codec.channels, description.tool_changer, description.e_stop
    if changer is None:
        yield "no tool changer in the description: IL-01 to IL-05 are off"
    else:
        bits = (("locked_bit", changer.locked_bit), ("unlocked_bit", changer.unlocked_bit))
        if missing := ", ".join(f"{key}: {bit}" for key, bit in bits if bit not in channels):
            yield f"tool changer: {missing}: a lock cannot be proven: IL-04 and IL-05 are off"
            if any(bit in channels for _, bit in bits):
                yield "tool changer: one bit of the two never proves LOCKED: no unlock is accepted"
        if changer.stand_bit not in channels:
            yield f"tool changer: stand_bit: {changer.stand_bit}: an unlock is armed first (IL-02)"
        elif changer.present_bit not in channels:
            yield f"tool changer: present_bit: {changer.present_bit}: an absent tool is not seen (IL-02, IL-05)"
    if e_stop is None:
        yield "no e-stop in the description: IL-13 covers only the software stop"
    elif e_stop.channel not in channels:
        yield f"e_stop: channel: {e_stop.channel}: an open e-stop is not seen: IL-13 covers only the software stop"


def _blow_offs(description: Description) -> Iterator[str]:
    """Yield a sentence for each blow-off that nothing drives.

    Also yield one for each blow-off during which later actuators may still hold.
    """
    for name, line in description.blow_off_lines.items():
        if name not in description.blow_offs:
            guarded = "is guarded by the line arbiter (IL-08)"
            yield f"{name}: blow_off: its line {line} {guarded}, but without duration_s nothing drives it"
    order = description.releasing
    for at, name in enumerate(order):
        if name in description.blow_offs and at + 1 < len(order):
            others = ", ".join(order[at + 1 :])
            yield f"{name}: blow_off: a release blows it off while {others} may still hold (release_order)"


def slow(description: Description, codec: CodecChannels) -> list[str]:
    """Return sentences about settings with unexpected effects, such as too short time-outs.

    A reading is valid until it is stale, so a time-out must last longer. The readings of one attempt must not count in
    the next, so the pause between attempts must last longer than a period. Other sentences concern contradicting
    evidence, the e-stop's wiring and blow-offs.
    """
    early, twice = _ends_too_early(description, codec), _read_twice(description, codec)
    return [
        *early,
        *twice,
        *overlapping_evidence(description),
        *_cut_e_stop(description),
        *_blow_offs(description),
    ]


def _cut_e_stop(description: Description) -> Iterator[str]:
    """Yield a sentence if the e-stop input's resistor pulls it to the level that means closed."""
    channel = description.e_stop.channel if description.e_stop else ""
    contact = description.channels.get(channel)
    digital = contact.digital if contact else None
    rests_at = {"pull_up": (1, "ground"), "pull_down": (0, "the supply")}.get(digital.bias if digital else "")
    if contact and digital and rests_at and contact.value(rests_at[0]) is True:
        yield (
            f"e_stop: {channel}: a cut wire reads as a closed e-stop, because of bias: {digital.bias} "
            f"({description.where('channels', channel, 'digital')}): wire a normally closed contact to "
            f"{rests_at[1]} and write invert: {str(not contact.invert).lower()}"
        )


def _ends_too_early(description: Description, codec: CodecChannels) -> Iterator[str]:
    period_s, stale_s = codec.period_us / 1e6, codec.stale_s
    for where, key, limit_s in _awaited(description, codec):
        if limit_s <= stale_s:
            yield (
                f"{where}: {key} = {number(limit_s)} s is over before a reading of {codec.codec} is stale "
                f"({number(stale_s)} s, one each {number(period_s)} s): a late or lost frame fails it"
            )


def _awaited(description: Description, codec: CodecChannels) -> Iterator[tuple[str, str, float]]:
    """Yield each proof that the sensors must show in time: device, key and length of its time-out, s."""
    for name, each in description.ordered:
        yield name, "timeout_s", each.timeout_s
        yield name, "release_s", each.release_s
    changer = description.tool_changer
    if changer and {changer.locked_bit, changer.unlocked_bit} <= codec.channels.keys():
        yield "tool changer", "prove_s", changer.prove_s


def _read_twice(description: Description, codec: CodecChannels) -> Iterator[str]:
    period_s = codec.period_us / 1e6
    for name, each in description.ordered:
        if each.reset_s <= period_s:
            yield (
                f"{name}: reset_s = {number(each.reset_s)} s is no longer than a period of {codec.codec} "
                f"({number(period_s)} s): what one attempt showed may confirm the next"
            )
