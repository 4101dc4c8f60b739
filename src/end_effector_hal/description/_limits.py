"""The range of a number, and the mistake of scale that put it out of range."""

from __future__ import annotations

from dataclasses import dataclass

from ._places import Keys
from ._shape import fields_of, stanza_at
from ._units import KILOPASCAL, convert, number, split

# unit of the key: units that somebody may have written instead
MISTAKES = {
    "s": (("ms", "milliseconds"), ("us", "microseconds")),
    "ms": (("us", "microseconds"), ("s", "seconds")),
    "kpa": (("pa", "pascal"), ("mbar", "millibar")),
    "fraction": (("percent", "percent"),),
}
SIGNS = {"s": "s", "ms": "ms", "kpa": "kPa"}


@dataclass(frozen=True)
class Limits:
    """Bounds of a number; ``above`` is not part of the range, ``least`` and ``most`` are."""

    above: float | None = None
    least: float | None = None
    most: float | None = None
    unit: str = ""

    def allow(self, value: float) -> bool:
        """Whether a number is in range."""
        return (
            (self.above is None or value > self.above)
            and (self.least is None or value >= self.least)
            and (self.most is None or value <= self.most)
        )

    def __str__(self) -> str:
        low = f"more than {number(self.above)}" if self.above is not None else ""
        low = f"at least {number(self.least)}" if self.least is not None else low
        high = f"at most {number(self.most)}" if self.most is not None else ""
        return " and ".join(each for each in (low, high) if each) + (
            f" {SIGNS[self.unit]}" if self.unit in SIGNS else ""
        )


def limits_of(path: Keys, kind: str) -> Limits:
    """The range that the model gives a number."""
    stanza = stanza_at(path[:-1], kind)
    field = fields_of(stanza).get(str(path[-1])) if stanza else None
    bounds: dict[str, float] = {}
    for each in field.metadata if field else ():
        bounds |= {name: getattr(each, name) for name in ("gt", "ge", "le") if hasattr(each, name)}
    return Limits(bounds.get("gt"), bounds.get("ge"), bounds.get("le"), split(str(path[-1]))[1])


def wrong_scale(key: str, value: object, limits: Limits) -> str:
    """``milliseconds? write timeout_s: 5``, or nothing."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return ""
    if limits.unit in KILOPASCAL and limits.allow(-value):
        return f"below ambient is positive here; write {key}: {number(-value)}"
    for unit, name in MISTAKES.get(limits.unit, ()):
        meant = convert(value, unit, limits.unit)
        if meant is not None and limits.allow(meant):
            return f"{name}? write {key}: {number(meant)}"
    return ""
