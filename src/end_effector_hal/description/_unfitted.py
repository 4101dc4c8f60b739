"""What is off because a tool has no sensor for it, or its codec shows too little: what cannot be proven then."""

from __future__ import annotations

from collections.abc import Iterator

from ._actuators import Actuator, CylinderActuator
from ._carried import Carried
from ._model import Description
from ._part import NO_CHANNEL
from ._units import number


def not_fitted(description: Description, carried: Carried) -> list[str]:
    """A sentence for each thing that is off because no wire carries what it needs."""
    actuators = (
        sentence for name, each in description.ordered for sentence in _actuator(name, each, carried)
    )
    return [*actuators, *_supply(description, carried), *_interlocks(description, carried)]


def _actuator(name: str, actuator: Actuator, carried: Carried) -> Iterator[str]:
    codec, kind = carried.codec, carried.channels.get(actuator.channel)
    if kind == "bit":
        yield f"{name}: {actuator.channel} is carried by {codec} as a bit: thresholds are off"
    if actuator.frozen_s is not None and kind == "pressure" and not carried.noise_shows:
        yield f"{name}: {codec} counts too coarsely to show a frozen sensor: frozen_s is off"
    if not isinstance(actuator, CylinderActuator):
        return
    if kind is None:
        proof = f"{actuator.extended_bit} alone proves extended, thresholds are off"
        yield f"{name}: channel: {actuator.channel}: {proof}: that its air is lost is not seen"
    for key, bit in (("extended_bit", actuator.extended_bit), ("retracted_bit", actuator.retracted_bit)):
        if bit not in carried.channels:
            yield f"{name}: {key}: {bit or NO_CHANNEL}: {_instead(actuator, key, carried)}"


def _instead(actuator: CylinderActuator, key: str, carried: Carried) -> str:
    """What proves a position whose bit is missing, and what is not seen then."""
    position = key.removesuffix("_bit")
    if actuator.channel in carried.channels:
        return f"the pressure {actuator.channel} alone proves {position}: a rod that is stuck is not seen"
    if position == "extended":
        return "extended cannot be proven"
    return (
        "retracted is taken as the opposite of extended: a rod that stops on its way is taken for retracted"
    )


def _supply(description: Description, carried: Carried) -> Iterator[str]:
    supply = description.supply
    kind = carried.channels.get(supply.channel)
    if kind == "bit":
        yield f"supply pressure: carried by {carried.codec} as a bit: IL-06 has no thresholds"
    elif kind is None:
        taken = f"{number(supply.nominal_kpa)} kPa is taken for it"
        yield f"supply: channel: {supply.channel}: IL-06 is off, {taken}: a lack of air is not seen"


def _interlocks(description: Description, carried: Carried) -> Iterator[str]:
    channels, changer, e_stop = carried.channels, description.tool_changer, description.e_stop
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
