"""Finds kinds of devices by name, built-in ones and plug-ins, and checks their declarations.

It also returns the meaning of a single switch for its kind: gripped, released, or gripped nothing.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from typing import Any, NamedTuple, get_args

from end_effector_hal.errors import UsageError
from end_effector_hal.kinds._guard import GuardedKind
from end_effector_hal.kinds._kind import DeviceKind
from end_effector_hal.kinds._parts import ChannelKey, Detector
from end_effector_hal.kinds.conditions import ConditionDetector, asked, shown
from end_effector_hal.kinds.stanza import NO_CHANNEL, Actuator, Condition, Supply
from end_effector_hal.plugins import Plugins, attempt
from end_effector_hal.signals import ChannelReadings, Kind
from end_effector_hal.vocabulary import ACTIVE, INACTIVE, PENDING, TableState

_NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")


def checked(kind: Any) -> DeviceKind[Any]:
    """Return the kind itself; raises UsageError if its declaration breaks a rule of `DeviceKind`."""
    if wrong := next(_wrong(kind), ""):
        raise UsageError(
            f"the kind declares {wrong}.",
            todo="Inherit end_effector_hal.kinds.conformance.KindConformance in its tests.",
        )
    found: DeviceKind[Any] = kind
    return found


def _wrong(kind: Any) -> Iterator[str]:
    if not isinstance(kind, DeviceKind):
        yield "no subclass of DeviceKind"
    missing = [key for key in ("name", "stanza", "channels", "states") if not hasattr(kind, key)]
    if missing:
        yield f"no {', '.join(missing)}"
    if type(kind.name) is not str or not _NAME.fullmatch(kind.name):
        yield "a name that is no word of lower-case letters, digits and '_'"
    if not (isinstance(kind.stanza, type) and issubclass(kind.stanza, Actuator)):
        yield "a stanza that does not inherit Actuator"
    fields = kind.stanza.model_fields
    if "kind" not in fields or get_args(fields["kind"].annotation) != (kind.name,):
        yield f'a stanza whose kind is not Literal["{kind.name}"]'
    if not isinstance(kind.channels, tuple) or not all(
        isinstance(each, ChannelKey) for each in kind.channels
    ):
        yield "channels that are no ChannelKey"
    keys = [kind.opposing, kind.samples, *(key for low, _, high in kind.orders for key in (low, high))]
    for key in filter(None, (*(each.key for each in kind.channels), *keys)):
        if key not in fields:
            yield f"{key!r}, which its stanza does not have"
    for each in kind.channels:
        if each.carries is Kind.BIT and not each.key.endswith("_bit"):
            yield f"{each.key!r}, a bit whose key does not end in _bit"
    if not any(each.confirms for each in kind.channels):
        yield "no channel that confirms"
    if type(kind).detector is DeviceKind.detector and type(kind).preset is DeviceKind.preset:
        yield "neither a preset nor a detector"
    states = kind.states
    if not (isinstance(states, type) and issubclass(states, TableState)):
        yield "states that are no TableState"
    if {int(state) for state in states} != {INACTIVE, PENDING, ACTIVE}:
        yield "other states than 0 inactive, 1 pending and 2 active"


GROUP = "end_effector_hal.kinds"
OWN = {
    "vacuum": "end_effector_hal.kinds.vacuum:Vacuum",
    "cylinder": "end_effector_hal.kinds.cylinder:Cylinder",
    "gripper": "end_effector_hal.kinds.gripper:Gripper",
    "magnet": "end_effector_hal.kinds.magnet:Magnet",
}


def kind_names() -> tuple[str, ...]:
    """Return all names that `get_kind` accepts, those of this product first."""
    return _KINDS.names


@cache
def get_kind(name: str) -> DeviceKind[Any]:
    """Return the kind of this name.

    Another distribution adds a kind, as a class or an object, by an entry point in ``end_effector_hal.kinds``.

    Raises:
        UsageError: no kind has this name (the error lists the known names), or it cannot be loaded.
    """
    kind = _KINDS.get(name)
    if kind.name != name:
        raise UsageError(
            f"the entry point {name} names the kind {kind.name}.", todo="Both have the same name."
        )
    _WANTED[name] = None
    return kind if name in OWN else attempt(f"The kind {name}", lambda: GuardedKind(kind))


def kind_of(actuator: Actuator) -> DeviceKind[Any]:
    """Return the kind of an actuator."""
    return get_kind(actuator.kind)


def detector_of(actuator: Actuator, supply: Supply) -> Detector:
    """Return a new detector of an actuator: by the evidence that it declares, else that of its kind."""
    return (
        ConditionDetector(actuator.evidence)
        if actuator.evidence
        else kind_of(actuator).detector(actuator, supply)
    )


def lost_words(actuator: Actuator, readings: ChannelReadings, at: int) -> str:
    """Return the readings of a lost actuator, as a phrase that follows ``… was lost:``."""
    if actuator.evidence:
        return shown(actuator.evidence.channels, readings, at)
    return kind_of(actuator).lost(actuator, readings, at)


def confirmed_words(actuator: Actuator, supply: Supply, readings: ChannelReadings, at: int) -> str:
    """Return the readings that do not confirm an actuator, and the values that would."""
    kind = kind_of(actuator)
    if conditions := kind.conditions(actuator):
        channels, wanted = list(conditions.confirmed.channels), asked(conditions.confirmed)
    else:
        channels, least = _carried(actuator, readings), kind.limits(actuator, supply).get("confirmed_kpa")
        wanted = "" if least is None else f"at least {least:g} kPa{_below(actuator)}"
    now = shown(channels, readings, at)
    return "; ".join(filter(None, (now, wanted and f"confirmed means {wanted}")))


def _carried(actuator: Actuator, readings: ChannelReadings) -> list[str]:
    return [each for each in kind_of(actuator).channel_names(actuator) if each in readings.carried]


def _below(actuator: Actuator) -> str:
    return " below ambient" if kind_of(actuator).below_ambient else ""


def present_words(actuator: Actuator, supply: Supply, readings: ChannelReadings, at: int) -> str:
    """Return the readings that contradict a release, the values that would prove it, and the remedy."""
    kind = kind_of(actuator)
    conditions = kind.conditions(actuator)
    if conditions:
        channels = list(conditions.gone.channels)
        gone = f"gone means {asked(conditions.gone)}"
    else:
        channels, least = _carried(actuator, readings), kind.limits(actuator, supply).get("gone_kpa")
        gone = f"gone means less than {least:g} kPa{_below(actuator)}" if least is not None else ""
    now = shown(channels, readings, at)
    # without a value it is no question of its zero
    read = any(readings.get(channel, at) is not None for channel in channels)
    zero = (
        " If nothing is gripped, ambient pressure or the zero of the sensor differs from what its channel says: "
        "correct its offset at rest."
        if kind.below_ambient and read
        else ""
    )
    return f"{'; '.join(filter(None, (now, gone)))}.{zero}"


def usable_kinds(names: Iterable[str] = ()) -> Mapping[str, DeviceKind[Any]]:
    """Return the built-in kinds, the named ones and all requested before, except those that cannot be loaded.

    A kind that no description names is not loaded, so the side effects of its import disturb nobody.
    """
    found = {}
    for name in dict.fromkeys((*OWN, *_WANTED, *names)):
        try:
            found[name] = get_kind(name)
        except UsageError:
            continue
    return found


def recorded_kind(name: str, kinds: Mapping[str, str]) -> DeviceKind[Any]:
    """Return the kind of an actuator in a recording, as its run.json names it.

    A recording without run.json has only names. Then the kind is the one whose name is part of the actuator's name,
    else the first one, whose OFF and ON fit any device.

    Raises:
        UsageError: run.json names a kind that is not installed.
    """
    if recorded := kinds.get(name):
        return get_kind(recorded)
    return get_kind(next((kind for kind in OWN if kind in name), next(iter(OWN))))


_WANTED: dict[str, None] = {}
"""Names of the kinds that were requested and could be loaded."""
_KINDS: Plugins[DeviceKind[Any]] = Plugins(GROUP, "kind of actuator", OWN, checked)


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


def switch_meanings(actuator: Actuator) -> dict[str, SwitchMeaning]:
    """Return the meaning of each bit that an actuator may have, by channel, carried or not.

    If several switches together prove something, each switch that must be on for it gets its word.
    """
    kind = kind_of(actuator)
    if (conditions := kind.conditions(actuator)) is not None:
        proven = [(word, each) for word, each in conditions.named if word in _PROVEN]
        bits = dict.fromkeys(leaf.channel for leaf in conditions.leaves if leaf.bit)
        return {name: SwitchMeaning(_on(name, proven), _proves(name, False, proven)) for name in bits}
    found = {}
    for key in kind.channels:
        name = getattr(actuator, key.key)
        if name and name != NO_CHANNEL and (key.carries is Kind.BIT or key.bit_instead):
            on = "confirmed" if key.confirms else key.meaning
            found[name] = SwitchMeaning(on, "gone" if key.bit_instead else "")
    return found


def _on(name: str, proven: list[tuple[str, Condition]]) -> str:
    if alone := _proves(name, True, proven):
        return alone
    sought = [(word, each.asked) for word, each in proven]
    return next((word for word, each in sought if each is not None and name in each.channels), "")


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
