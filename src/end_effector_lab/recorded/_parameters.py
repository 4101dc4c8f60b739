"""Select the numbers of a description that can be tried on recorded grips, and the values to try."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from end_effector_hal.codecs import carrier_of
from end_effector_hal.description import SAME_FOR_ALL_PARTS, Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.kinds.stanza import Actuator, Supply
from end_effector_hal.signals import Kind

WAITS = ("timeout_s", "release_s", "attempts")
"""Keys of every actuator that limit a wait or the number of attempts; the evidence of the sensors does not depend on
them.
"""
UNITS = {"_kpa": "kPa", "_s": "s", "_ms": "ms", "_samples": "samples", "_fraction": ""}
STEPS = 24
LEAST, MOST = 0.2, 2.0
"""Range of the tried values, as multiples of the current value; for waits the lower end is `LEAST_WAIT`, in equal
ratios.
"""
LEAST_WAIT = 0.02
_WARNS = "it only warns: no grip succeeds or fails by it"
_OTHER_PAUSE = "what another pause would have changed is in no recording"
_FROZEN = "it says which readings count, and no grip was decided by it alone"
_NO_PRESSURE = "no pressure of it is measured, so that its thresholds are off"
_OF_PRESSURES = ("_kpa", "_fraction")
_NOT_BY_GRIPS = "no recorded grip was decided by it"

Path = tuple[str | int, ...]


@dataclass(frozen=True)
class TunableKey:
    """A number in one actuator's stanza.

    Attributes:
        actuator: name of the actuator.
        part: name of the part for which it is tried; empty: the tool names no parts.
        path: the keys within its stanza.
        today: its current value.
        whole: whether only whole numbers are valid.
    """

    actuator: str
    path: Path
    today: float
    whole: bool
    part: str = ""

    @property
    def key(self) -> str:
        """The full key, such as ``actuators.cylinder.timeout_s`` or ``parts.box.actuators.cylinder.timeout_s``."""
        key = ".".join(map(str, ("actuators", self.actuator, *self.path)))
        own = self.part and self.path[0] not in SAME_FOR_ALL_PARTS
        return f"parts.{self.part}.{key}" if own else key

    @property
    def unit(self) -> str:
        """Unit of its value; empty: none."""
        return next((unit for end, unit in UNITS.items() if str(self.path[-1]).endswith(end)), "")

    @property
    def waits(self) -> bool:
        """Whether the key is one of `WAITS`."""
        return self.path[0] in WAITS

    def with_value(self, actuator: Actuator, supply: Supply, value: float) -> Actuator | None:
        """Return the actuator with another value; None: the value alone is invalid."""
        tree = actuator.model_dump(by_alias=True, mode="json")
        place: Any = tree
        for key in self.path[:-1]:
            place = place[key]
        place[self.path[-1]] = int(value) if self.whole else value
        try:
            found = type(actuator).model_validate(tree)
        except (ValidationError, ValueError):
            return None
        return found if _consistent(found, supply) else None

    def grid(self) -> list[float]:
        """Return the values to try, in order, including the current one.

        For ``attempts`` the current value is the highest, because no recording has more attempts.
        """
        if self.path == ("attempts",):
            return [float(number) for number in range(1, int(self.today) + 1)]
        low, high = sorted((LEAST * self.today, MOST * self.today))
        shares = [index / STEPS for index in range(STEPS + 1)]
        values = {low + (high - low) * share for share in shares} | {self.today}
        if self.waits:
            values |= {high * (LEAST_WAIT / MOST) ** share for share in shares}
        if self.whole:
            values = {float(round(value)) for value in values} | {self.today}
        return sorted({_short(value, self.today) for value in values})


def parameters_of(description: Description, part: str = "") -> Iterator[TunableKey]:
    """Yield the thresholds and time-outs of all actuators for a part, in the order of a grip."""
    for name, actuator in description.for_part(part).ordered:
        for key in WAITS:
            yield TunableKey(name, (key,), float(getattr(actuator, key)), key == "attempts", part)
        if actuator.evidence is not None:
            tree = actuator.evidence.model_dump(by_alias=True)
            for path, value in _numbers(tree):
                yield TunableKey(name, ("evidence", *path), float(value), isinstance(value, int), part)
            continue
        for key, value in _own(actuator):
            if not key.startswith("secure") and not _is_idle(description, actuator, key):
                yield TunableKey(name, (key,), float(value), isinstance(value, int), part)


def not_tried(description: Description) -> Iterator[tuple[str, str]]:
    """Yield keys of times and thresholds that no recorded grip can judge, with the reason."""
    for name, actuator in description.ordered:
        yield f"actuators.{name}.reset_s", _OTHER_PAUSE
        if actuator.frozen_s is not None:
            yield f"actuators.{name}.frozen_s", _FROZEN
        for key, _ in _own(actuator):
            if key.startswith("secure"):
                yield f"actuators.{name}.{key}", _WARNS
            elif actuator.evidence is None and _is_idle(description, actuator, key):
                yield f"actuators.{name}.{key}", _NO_PRESSURE
    yield "hold.*", _WARNS
    yield "supply.*", _NOT_BY_GRIPS
    yield "link.*", _FROZEN
    if description.tool_changer is not None:
        yield "tool_changer.*", _NOT_BY_GRIPS


def _is_idle(description: Description, actuator: Actuator, key: str) -> bool:
    """Return whether the key is a threshold of a pressure that the link lacks: only a switch is evidence."""
    return (
        key.endswith(_OF_PRESSURES)
        and carrier_of(description).channels.get(actuator.channel) is not Kind.PRESSURE
    )


def _own(actuator: Actuator) -> Iterator[tuple[str, float]]:
    """Yield the numbers that only this kind of actuator has."""
    for key in type(actuator).model_fields:
        value = getattr(actuator, key)
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if number and key not in Actuator.model_fields and key.endswith(tuple(UNITS)):
            yield key, value


def _numbers(tree: Any, path: Path = ()) -> Iterator[tuple[Path, float]]:
    """Yield the thresholds and times of declared conditions."""
    items = (
        tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list | tuple) else ()
    )
    for key, value in items:
        if isinstance(value, dict | list | tuple):
            yield from _numbers(value, (*path, key))
        elif isinstance(value, int | float) and not isinstance(value, bool):
            yield (*path, key), value


def _consistent(actuator: Actuator, supply: Supply) -> bool:
    """Return whether the numbers are in the order that `eehal check` requires."""
    kind = kind_of(actuator)
    for low, relation, high in kind.orders:
        less, more = getattr(actuator, low), getattr(actuator, high)
        if less is not None and more is not None and not (less < more or (relation == "<=" and less == more)):
            return False
    for rule in kind.joint_rules:
        numbers = {
            key: getattr(supply, key.removeprefix("supply."))
            if key.startswith("supply.")
            else getattr(actuator, key)
            for key in rule.keys
        }
        if None not in numbers.values() and rule.fault("", numbers, lambda key: key):
            return False
    return True


def _short(value: float, today: float) -> float:
    """Round a tried value to three digits, which are enough; the current value is not rounded."""
    return value if value == today else float(f"{value:.3g}")
