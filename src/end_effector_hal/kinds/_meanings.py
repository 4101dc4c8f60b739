"""The meaning of a single switch: its actuator grips, has released, or has gripped nothing."""

from __future__ import annotations

from typing import NamedTuple

from end_effector_hal.signals import Kind

from ._registry import kind_of
from .stanza import NO_CHANNEL, Actuator, Condition

_PROVEN = ("confirmed", "gone", "empty")


class SwitchMeaning(NamedTuple):
    """The words for what a switch proves while on and while off; empty: it proves nothing by itself."""

    on: str
    off: str

    def words(self, level: bool | None) -> str:
        """Return a phrase such as ``on: confirmed``; ``not known`` if there is no valid reading."""
        if level is None:
            return "not known"
        meaning = self.on if level else self.off
        return f"{'on' if level else 'off'}{meaning and ': '}{meaning}"


def switch_meanings(part: Actuator) -> dict[str, SwitchMeaning]:
    """Return the meaning of each bit that an actuator may have, by channel, carried or not.

    If several switches together prove something, each switch that must be on for it gets its word.
    """
    kind = kind_of(part)
    if (conditions := kind.conditions(part)) is not None:
        proven = [(word, each) for word, each in conditions.named if word in _PROVEN]
        bits = dict.fromkeys(leaf.channel for leaf in conditions.leaves if leaf.bit)
        return {name: SwitchMeaning(_on(name, proven), _proves(name, False, proven)) for name in bits}
    found = {}
    for asked in kind.channels:
        name = getattr(part, asked.key)
        if name and name != NO_CHANNEL and (asked.carries is Kind.BIT or asked.bit_instead):
            on = "confirmed" if asked.confirms else asked.meaning
            found[name] = SwitchMeaning(on, "gone" if asked.bit_instead else "")
    return found


def _on(name: str, proven: list[tuple[str, Condition]]) -> str:
    if alone := _proves(name, True, proven):
        return alone
    asked = [(word, each.asked) for word, each in proven]
    return next((word for word, each in asked if each is not None and name in each.channels), "")


def _proves(name: str, level: bool, proven: list[tuple[str, Condition]]) -> str:
    return next((word for word, each in proven if _shown(each, name, level)), "")


def _shown(condition: Condition, name: str, level: bool) -> bool | None:
    """Return whether a condition holds if only this one bit is known; None: this bit does not decide it."""
    if condition.not_ is not None:
        inside = _shown(condition.not_, name, level)
        return None if inside is None else not inside
    if not condition.parts:
        return level if condition.on == name else None
    found = [_shown(each, name, level) for each in condition.parts]
    decided = bool(condition.any)
    if decided in found:
        return decided
    return None if None in found else not decided
