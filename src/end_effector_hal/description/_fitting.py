"""What a codec carries against what a description needs: not fitted, or not to be proven at all.

Codecs belong to a higher layer; here one is its period and what it carries, ``"pressure"`` or ``"bit"``.
"""

from __future__ import annotations

from collections.abc import Iterator

from ._actuators import Actuator, VacuumActuator
from ._carried import Carried, can_be_confirmed, no_bits, position_bits, provers, too_soon, unwired
from ._fault import Fault, did_you_mean
from ._model import Description
from ._units import number


def unproven(description: Description, carried: Carried) -> list[Fault]:
    """A fault for each actuator that can never be confirmed over this link, in the order of the file.

    And for each channel that is asked for and not carried: it must not switch off a proof in silence.
    """
    found = [
        fault for name, each in description.ordered for fault in _unproven(description, carried, name, each)
    ]
    named = [*unwired(description, carried), *no_bits(description, carried)]
    return sorted([*found, *named, *too_soon(description, carried)])


def _unproven(description: Description, carried: Carried, name: str, actuator: Actuator) -> Iterator[Fault]:
    if not can_be_confirmed(actuator, carried):
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
