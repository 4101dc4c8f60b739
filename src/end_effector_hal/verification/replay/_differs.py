"""Find where two records differ."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from end_effector_hal.control import word_of
from end_effector_hal.description import Description

NOTHING = "nothing"
_UNTOLD = frozenset({"where"})
"""Fields that are not compared: the place of an edge in its file is not part of a decision."""


@dataclass(frozen=True, slots=True)
class Difference:
    """The first decision that differs.

    Attributes:
        at: time of the record, µs.
        what: kind of the record, and the field in it.
        recorded, replayed: the values.
        names: the words for the two values, if they are numbers of Table II or similar.
    """

    at: int
    what: str
    recorded: object
    replayed: object
    names: tuple[str | None, str | None] = (None, None)

    def __str__(self) -> str:
        old, new = (
            f"{_short(value)} ({name})" if name else _short(value)
            for value, name in zip((self.recorded, self.replayed), self.names, strict=True)
        )
        return f"{self.what}: recorded {old}, replayed {new}"

    def named(self, description: Description) -> Difference:
        """Return a copy with the words of a tool for its numbers."""
        variable = self.what.rpartition(".")[2].replace("actuators[", "actuator[")
        old, new = (
            word_of(description, variable, value) if type(value) is int else None
            for value in (self.recorded, self.replayed)
        )
        return replace(self, names=(old, new))


def first_difference(kind: str, recorded: Any, replayed: Any) -> Difference | None:
    """Return the first field that differs; None: none does."""
    found = _differs(recorded, replayed, kind)
    if found is None:
        return None
    what, old, new = found
    return Difference(recorded["at"], what, old, new)


def _differs(old: Any, new: Any, what: str) -> tuple[str, Any, Any] | None:
    if isinstance(old, dict) and isinstance(new, dict):
        for key in sorted((old.keys() | new.keys()) - _UNTOLD):
            found = _differs(old.get(key, NOTHING), new.get(key, NOTHING), f"{what}.{key}")
            if found:
                return found
        return None
    if isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        pairs = enumerate(zip(old, new, strict=True))
        return next((found for i, (a, b) in pairs if (found := _differs(a, b, f"{what}[{i}]"))), None)
    return None if old == new and isinstance(old, bool) == isinstance(new, bool) else (what, old, new)


def _short(value: object) -> str:
    text = value if isinstance(value, str) else repr(value)
    return text if len(text) <= 120 else text[:117] + "…"
