"""The values that are good, for rules that compare several of them while others are still broken."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ._places import Keys, Places
from ._shape import fields_of, stanza_at


@dataclass(frozen=True)
class Facts:
    """A tree of values, the places of them, and the paths that already have a fault."""

    tree: dict[str, Any]
    places: Places
    broken: set[Keys] = field(default_factory=set)

    def written(self, *path: str | int) -> bool:
        """Whether the key stands in the file."""
        return path in self.places.values

    def get(self, *path: str | int) -> Any:
        """The value; the default if it is not written; None if it is broken or there is none."""
        if any(path[:length] in self.broken for length in range(len(path) + 1)):
            return None
        value: Any = self.tree
        for key in path:
            if not isinstance(value, dict) or key not in value:
                return self._default(path)
            value = value[key]
        return value

    def _default(self, path: Keys) -> Any:
        stanza = stanza_at(path[:-1], self._kind(path))
        found = fields_of(stanza).get(str(path[-1])) if stanza else None
        return None if found is None or found.is_required() else found.default

    def _kind(self, path: Keys) -> str:
        return (
            str(self.tree["actuators"][path[1]]["kind"]) if path[0] == "actuators" and len(path) > 2 else ""
        )

    def names(self, *path: str | int) -> list[str]:
        """The elements of a list that are texts, or the keys of a mapping; empty if it is broken."""
        value = self.get(*path)
        return [str(each) for each in value or ()]

    def actuators(self) -> list[tuple[str, str]]:
        """Name and kind of each actuator whose stanza can be read."""
        stanzas = self.tree.get("actuators")
        if not isinstance(stanzas, dict):
            return []
        return [(name, each["kind"]) for name, each in stanzas.items() if isinstance(each, dict)]
