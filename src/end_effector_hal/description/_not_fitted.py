"""What is off because a tool has no sensor for it, or its codec shows too little: what cannot be proven then."""

from __future__ import annotations

from collections.abc import Iterator

from end_effector_hal.kinds import kind_of
from end_effector_hal.kinds.stanza import Actuator
from end_effector_hal.signals import Kind

from ._codec_channels import CodecChannels
from ._model import Description
from ._units import number


def not_fitted(description: Description, codec: CodecChannels) -> list[str]:
    """A sentence for each thing that is off because no wire carries what it needs."""
    actuators = (sentence for name, each in description.ordered for sentence in _actuator(name, each, codec))
    return [*actuators, *_supply(description, codec), *_interlocks(description, codec)]


def _actuator(name: str, actuator: Actuator, codec: CodecChannels) -> Iterator[str]:
    carries = codec.channels.get(actuator.channel)
    if carries is Kind.BIT:
        yield f"{name}: {actuator.channel} is carried by {codec.codec} as a bit: thresholds are off"
    if actuator.frozen_s is not None and carries is Kind.PRESSURE and not codec.noise_shows:
        yield f"{name}: {codec.codec} counts too coarsely to show a frozen sensor: frozen_s is off"
    for phrase in kind_of(actuator).not_fitted(actuator, codec.channels):
        yield f"{name}: {phrase}"


def _supply(description: Description, codec: CodecChannels) -> Iterator[str]:
    supply = description.supply
    carries = codec.channels.get(supply.channel)
    if carries is Kind.BIT:
        yield f"supply pressure: carried by {codec.codec} as a bit: IL-06 has no thresholds"
    elif carries is None:
        taken = f"{number(supply.nominal_kpa)} kPa is taken for it"
        yield f"supply: channel: {supply.channel}: IL-06 is off, {taken}: a lack of air is not seen"


def _interlocks(description: Description, codec: CodecChannels) -> Iterator[str]:
    channels, changer, e_stop = codec.channels, description.tool_changer, description.e_stop
    if changer is None:
        yield "tool changer: none in the description: IL-01 to IL-05 are off"
    else:
        bits = (("locked_bit", changer.locked_bit), ("unlocked_bit", changer.unlocked_bit))
        if missing := ", ".join(f"{key}: {bit}" for key, bit in bits if bit not in channels):
            yield f"tool changer: {missing}: a lock cannot be proven: IL-04 and IL-05 are off"
        if changer.stand_bit not in channels:
            yield f"tool changer: stand_bit: {changer.stand_bit}: an unlock is armed first (IL-02)"
        elif changer.present_bit not in channels:
            yield f"tool changer: present_bit: {changer.present_bit}: an absent tool is not seen (IL-02)"
    for name, line in description.blow_off_lines.items():
        yield f"{name}: its blow-off {line} is guarded by the line arbiter (IL-08), but no command drives it"
    if e_stop is None:
        yield "e-stop: none in the description: IL-13 is off"
    elif e_stop.channel not in channels:
        yield f"e_stop: channel: {e_stop.channel}: an open e-stop is not seen: IL-13 is off"
