"""Which channels of the link a description names, where, and what for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

from end_effector_hal.kinds import kind_of, usable_kinds
from end_effector_hal.kinds.stanza import NO_CHANNEL, Part
from end_effector_hal.signals import Kind

from ._devices import EStop, ToolChanger
from ._model import Description

_CHANGER = ("locked_bit", "unlocked_bit", "stand_bit", "present_bit")


@dataclass(frozen=True)
class Use:
    """A channel and the key that names it; ``bit``: it says yes or no, else it is a pressure."""

    stanza: tuple[str, ...]
    key: str
    channel: str
    bit: bool
    written: bool


def uses(description: Description) -> tuple[Use, ...]:
    """Every channel that a description asks for, its defaults too, and not what is declared `NO_CHANNEL`."""
    return tuple(_uses(description))


def used_channels(description: Description) -> tuple[str, ...]:
    """Their names, each once: of the actuators in sequence order, the other devices, the supply.

    What else a link carries does not matter to this tool.
    """
    return tuple(dict.fromkeys(use.channel for use in _uses(description)))


def _uses(description: Description) -> Iterator[Use]:
    for name, each in description.ordered:
        for asked in kind_of(each).channels:
            yield from _of(("actuators", name), each, asked.key, bit=asked.carries is Kind.BIT)
    if description.tool_changer:
        for key in _CHANGER:
            yield from _of(("tool_changer",), description.tool_changer, key, bit=True)
    if description.e_stop:
        yield from _of(("e_stop",), description.e_stop, "channel", bit=True)
    yield from _of(("supply",), description.supply, "channel", bit=False)


def _of(stanza: tuple[str, ...], part: Part, key: str, *, bit: bool) -> Iterator[Use]:
    channel = getattr(part, key)
    if channel and channel != NO_CHANNEL:
        yield Use(stanza, key, channel, bit, key in part.model_fields_set)


@cache
def bits_by_default() -> frozenset[str]:
    """Names of bits that mean something, whether this tool has the device or not."""
    keyed: list[tuple[type[Part], tuple[str, ...]]] = [(ToolChanger, _CHANGER), (EStop, ("channel",))]
    keyed += [
        (kind.stanza, tuple(each.key for each in kind.channels if each.carries is Kind.BIT))
        for kind in usable_kinds().values()
    ]
    return frozenset(str(model.model_fields[key].default) for model, keys in keyed for key in keys)
