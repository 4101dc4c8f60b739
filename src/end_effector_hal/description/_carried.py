"""What comes over the link, and what a description says of it that cannot be meant."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from ._actuators import Actuator, CylinderActuator
from ._devices import Supply
from ._fault import Fault, did_you_mean
from ._model import Description
from ._part import Part
from ._units import number

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

    @property
    def listed(self) -> str:
        """For a sentence: which channels there are."""
        return f"a channel of {self.codec}: {', '.join(self.channels)}"


def misspelt(description: Description, carried: Carried) -> Iterator[Fault]:
    """Names of channels that are written and meant another one."""
    for stanza, part, keys in _named(description):
        for key in keys:
            name = getattr(part, key)
            written = key in part.model_fields_set and name is not None
            if written and name not in carried.channels and (hint := did_you_mean(name, carried.channels)):
                what = f"{carried.codec} carries no {name!r}"
                yield Fault.at(
                    description.place(*stanza, key), "EE-225", what, expected=carried.listed, hint=hint
                )


def _named(description: Description) -> Iterator[tuple[tuple[str, ...], Part, tuple[str, ...]]]:
    """Stanzas with the keys that name a channel without which something is off."""
    yield ("supply",), description.supply, ("channel",)
    if description.tool_changer:
        yield ("tool_changer",), description.tool_changer, ("locked_bit", "unlocked_bit")
    if description.e_stop:
        yield ("e_stop",), description.e_stop, ("channel",)
    for name, each in description.ordered:
        if isinstance(each, CylinderActuator):
            yield ("actuators", name), each, ("extended_bit", "retracted_bit")


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
