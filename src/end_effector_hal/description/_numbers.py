"""Units in keys (``timeout_s`` is in seconds, ``gone_kpa`` in kPa), ranges, and hints for wrong units."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

from ._fault import Keys
from ._shape import fields_of, stanza_at

SECONDS = {"s": 1.0, "sec": 1.0, "seconds": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0}
KILOPASCAL = {"kpa": 1.0, "pa": 1e-3, "hpa": 0.1, "mbar": 0.1, "bar": 100.0, "mpa": 1000.0, "psi": 6.894757}
FRACTION = {"fraction": 1.0, "percent": 0.01}
MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}
QUANTITIES = (SECONDS, KILOPASCAL, FRACTION, MILLIMETRES)
WORDS = {
    "s": "seconds",
    "ms": "milliseconds",
    "kpa": "kPa",
    "fraction": "a fraction of 1",
    "mm": "millimetres",
}


def split(key: str) -> tuple[str, str]:
    """Return the stem and the unit of a key, such as ``("timeout", "s")``; the unit is empty if missing."""
    stem, _, unit = key.rpartition("_")
    return (stem, unit.lower()) if stem and any(unit.lower() in each for each in QUANTITIES) else (key, "")


def convert(value: object, of: str, to: str) -> float | None:
    """Return a number in another unit of the same quantity; None: not a number, or other quantities."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    return next((value * each[of] / each[to] for each in QUANTITIES if of in each and to in each), None)


def right_key(key: str, value: object, keys: Iterable[str]) -> tuple[str, str] | None:
    """Return the known key with the same stem and another unit, and how to write it; None: none."""
    stem, unit = split(key)
    for known in keys:
        right_stem, right_unit = split(known)
        same = not unit or convert(1, unit, right_unit) is not None
        if right_unit and right_stem == stem and right_unit != unit and same:
            converted = convert(value, unit, right_unit) if unit else None
            return known, known if converted is None else f"{known}: {number(converted)}"
    return None


def with_unit(text: str) -> tuple[float, str] | None:
    """Return ``5 s`` as ``(5.0, "s")``, and a number alone with the unit ``""``; None: it is no number."""
    match = re.fullmatch(r"\s*([-+]?\d{1,12}(?:[.,]\d{1,12})?)\s*(%|[A-Za-z]*)\s*", text)
    if not match:
        return None
    return float(match[1].replace(",", ".")), match[2].lower().replace("%", "percent")


def number(value: float) -> str:
    """Return a number as text without unnecessary digits."""
    return f"{value:.10g}"


# unit of the key: units that somebody may have written instead
MISTAKES = {
    "s": (("ms", "milliseconds"), ("us", "microseconds")),
    "ms": (("us", "microseconds"), ("s", "seconds")),
    "kpa": (("pa", "pascal"), ("mbar", "millibar")),
    "fraction": (("percent", "percent"),),
}
SIGNS = {"s": "s", "ms": "ms", "kpa": "kPa", "mm": "mm"}


@dataclass(frozen=True)
class Limits:
    """Bounds of a number; ``above`` is exclusive, ``least`` and ``most`` are inclusive."""

    above: float | None = None
    least: float | None = None
    most: float | None = None
    unit: str = ""

    def allow(self, value: float) -> bool:
        """Return whether a number is in range."""
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
    """Return the range of a number as the model defines it."""
    stanza = stanza_at(path[:-1], kind)
    field = fields_of(stanza).get(str(path[-1])) if stanza else None
    bounds: dict[str, float] = {}
    for each in field.metadata if field else ():
        bounds |= {name: getattr(each, name) for name in ("gt", "ge", "le") if hasattr(each, name)}
    return Limits(bounds.get("gt"), bounds.get("ge"), bounds.get("le"), split(str(path[-1]))[1])


def wrong_scale(key: str, value: object, limits: Limits) -> str:
    """Return a hint such as ``milliseconds? write timeout_s: 5`` for a wrong unit; empty: none fits."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return ""
    if limits.unit in KILOPASCAL and limits.least is None and limits.allow(-value):
        return f"below ambient is positive here; write {key}: {number(-value)}"
    for unit, name in MISTAKES.get(limits.unit, ()):
        meant = convert(value, unit, limits.unit)
        if meant is not None and limits.allow(meant):
            return f"{name}? write {key}: {number(meant)}"
    return ""
