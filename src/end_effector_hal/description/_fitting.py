"""What a codec carries against what a description needs: not fitted, or not to be proven at all.

Codecs belong to a higher layer; here one is its period and what it carries, ``"pressure"`` or ``"bit"``.
"""

from __future__ import annotations

from collections.abc import Iterator

from ._actuators import Actuator, CylinderActuator, VacuumActuator
from ._carried import Carried, misspelt, no_bits, position_bits, provers, too_soon
from ._fault import Fault, did_you_mean
from ._model import Description
from ._units import number


def unproven(description: Description, carried: Carried) -> list[Fault]:
    """A fault for each actuator that can never be confirmed over this link, in the order of the file.

    And for each name that is written and misspelt: it must not switch off an interlock in silence.
    """
    found = [
        fault for name, each in description.ordered for fault in _unproven(description, carried, name, each)
    ]
    named = [*misspelt(description, carried), *no_bits(description, carried)]
    return sorted([*found, *named, *too_soon(description, carried)])


def _unproven(description: Description, carried: Carried, name: str, actuator: Actuator) -> Iterator[Fault]:
    bits = _bits(actuator)
    if not any(channel in carried.channels for channel in (actuator.channel, *bits)):
        place = description.place("actuators", name, "channel")
        what = f"{carried.codec} carries nothing that could confirm {name!r}"
        hint = did_you_mean(actuator.channel, _meant(actuator, carried))
        yield Fault.at(place, "EE-225", what, expected=provers(description, carried, name), hint=hint)
    if carried.channels.get(actuator.channel) == "bit" and actuator.channel in position_bits(description):
        place = description.place("actuators", name, "channel")
        what = f"{actuator.channel!r} is a position bit and no pressure"
        yield Fault.at(place, "EE-225", what, expected=provers(description, carried, name))
    if isinstance(actuator, VacuumActuator):
        least_s = (actuator.confirmed_samples - 1) * carried.period_us / 1e6
        if least_s >= actuator.timeout_s:
            place = description.place("actuators", name, "confirmed_samples")
            samples = f"{actuator.confirmed_samples} samples take {number(least_s)} s"
            what = f"{name!r} can never be confirmed: {samples}"
            expected = f"less than timeout_s = {number(actuator.timeout_s)}"
            yield Fault.at(place, "EE-225", what, found=carried.codec, expected=expected)


def _meant(actuator: Actuator, carried: Carried) -> tuple[str, ...]:
    """Names that somebody may have misspelt."""
    return carried.of("pressure") or (carried.of("bit") if isinstance(actuator, VacuumActuator) else ())


def not_fitted(description: Description, carried: Carried) -> list[str]:
    """A sentence for each thing that is off because the link does not carry what it needs."""
    return [*_devices(description, carried), *_interlocks(description, carried)]


def _devices(description: Description, carried: Carried) -> Iterator[str]:
    channels, codec = carried.channels, carried.codec
    for name, actuator in description.ordered:
        kind = channels.get(actuator.channel)
        if kind == "bit":
            yield f"{name}: {actuator.channel} is carried by {codec} as a bit: thresholds are off"
        elif kind is None:
            yield f"{name}: {actuator.channel} is not carried by {codec}: thresholds are off"
        if actuator.frozen_s is not None and kind == "pressure" and not carried.noise_shows:
            yield f"{name}: {codec} counts too coarsely to show a frozen sensor: frozen_s is off"
        for bit in _bits(actuator):
            if bit not in channels:
                yield f"{name}: {bit} is not carried by {codec}: {_instead(actuator, bit, kind)}"
    if kind_of_supply := channels.get(description.supply.channel):
        if kind_of_supply == "bit":
            yield f"supply pressure: carried by {codec} as a bit: IL-06 has no thresholds"
    else:
        nominal = number(description.supply.nominal_kpa)
        yield f"supply pressure: not carried by {codec}: IL-06 is off, {nominal} kPa is taken for it"


def _interlocks(description: Description, carried: Carried) -> Iterator[str]:
    channels, codec = carried.channels, carried.codec
    changer = description.tool_changer
    if changer is None:
        yield "tool changer: none in the description: IL-01 to IL-05 are off"
    elif missing := [bit for bit in (changer.locked_bit, changer.unlocked_bit) if bit not in channels]:
        yield f"tool changer: not carried by {codec}: {', '.join(missing)}: IL-04 and IL-05 are off"
    if changer and changer.stand_bit not in channels:
        yield f"tool stand: not carried by {codec}: {changer.stand_bit}: an unlock is armed first (IL-02)"
    elif changer and changer.present_bit not in channels:
        yield f"tool stand: not carried by {codec}: {changer.present_bit}: an absent tool is not seen (IL-02)"
    for name, line in description.blow_off_lines.items():
        yield f"{name}: its blow-off {line} is guarded by the line owner (IL-08), but no command drives it"
    e_stop = description.e_stop
    if e_stop is None:
        yield "e-stop: none in the description: IL-13 is off"
    elif e_stop.channel not in channels:
        yield f"e-stop: not carried by {codec}: {e_stop.channel}: IL-13 is off"


def _instead(actuator: Actuator, bit: str, kind: str | None) -> str:
    """What proves a position whose bit is missing."""
    extended = isinstance(actuator, CylinderActuator) and bit == actuator.extended_bit
    if kind is not None:
        return f"{actuator.channel} alone proves it"
    return "extended cannot be proven" if extended else "it is taken as the opposite of extended"


def _bits(actuator: Actuator) -> tuple[str, ...]:
    bits = (actuator.extended_bit, actuator.retracted_bit) if isinstance(actuator, CylinderActuator) else ()
    return tuple(bit for bit in bits if bit)
