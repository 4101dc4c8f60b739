"""Where two records differ."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

NOTHING = "nothing"
_UNTOLD = frozenset({"where"})
"""Where an edge stands in a file is no decision."""


@dataclass(frozen=True, slots=True)
class Difference:
    """The first thing that was decided in another way.

    Attributes:
        at: µs, of the record.
        what: kind of the record, and the field in it.
        recorded, replayed: the values.
    """

    at: int
    what: str
    recorded: object
    replayed: object

    def __str__(self) -> str:
        return f"{self.what}: recorded {_short(self.recorded)}, replayed {_short(self.replayed)}"


def first_difference(kind: str, recorded: Any, replayed: Any) -> Difference | None:
    """The first field that differs. Fields of a status that only one of them knows come from another version."""
    found = _differs(recorded, replayed, kind, lenient=kind == "status")
    if found is None:
        return None
    what, old, new = found
    return Difference(recorded["at"], what, old, new)


def _differs(old: Any, new: Any, what: str, *, lenient: bool = False) -> tuple[str, Any, Any] | None:
    if isinstance(old, dict) and isinstance(new, dict):
        for key in sorted((old.keys() & new.keys() if lenient else old.keys() | new.keys()) - _UNTOLD):
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
