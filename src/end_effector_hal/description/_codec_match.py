"""What a codec carries against what a description needs: what can never be proven.

Codecs belong to a higher layer; here one is its period and what it carries.
"""

from __future__ import annotations

from collections.abc import Iterator

from end_effector_hal.kinds import kind_of
from end_effector_hal.kinds.stanza import Actuator
from end_effector_hal.signals import Kind

from ._codec_channels import (
    CodecChannels,
    can_be_confirmed,
    no_bits,
    position_bits,
    provers,
    too_soon,
    unwired,
)
from ._fault import Fault, did_you_mean
from ._model import Description
from ._units import number


def unproven(description: Description, codec: CodecChannels) -> list[Fault]:
    """A fault for each actuator that can never be confirmed over this link, in the order of the file.

    And for each channel that is asked for and not carried: it must not switch off a proof in silence.
    """
    found = [
        fault for name, each in description.ordered for fault in _unproven(description, codec, name, each)
    ]
    named = [*unwired(description, codec), *no_bits(description, codec)]
    return sorted([*found, *named, *too_soon(description, codec)])


def _unproven(
    description: Description, codec: CodecChannels, name: str, actuator: Actuator
) -> Iterator[Fault]:
    kind = kind_of(actuator)
    if not can_be_confirmed(actuator, codec):
        proof = next(each for each in kind.channels if each.confirms)
        place = description.place("actuators", name, proof.key)
        what = f"{codec.codec} carries nothing that could confirm {name!r}"
        meant = codec.of(proof.carries) or (codec.of(Kind.BIT) if proof.bit_instead else ())
        hint = did_you_mean(getattr(actuator, proof.key), meant)
        yield Fault.at(place, "EE-225", what, expected=provers(description, codec, name), hint=hint)
    if codec.channels.get(actuator.channel) is Kind.BIT and actuator.channel in position_bits(description):
        place = description.place("actuators", name, "channel")
        what = f"{actuator.channel!r} is a position bit and no pressure"
        yield Fault.at(place, "EE-225", what, expected=provers(description, codec, name))
    if kind.samples:
        samples = getattr(actuator, kind.samples)
        least_s = (samples - 1) * codec.period_us / 1e6
        if least_s >= actuator.timeout_s:
            place = description.place("actuators", name, kind.samples)
            what = f"{name!r} can never be confirmed: {samples} samples take {number(least_s)} s"
            expected = f"less than timeout_s = {number(actuator.timeout_s)}"
            yield Fault.at(place, "EE-225", what, found=codec.codec, expected=expected)
