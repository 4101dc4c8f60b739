"""Where each value of a description stands in its file."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

Keys = tuple[str | int, ...]


@dataclass(frozen=True)
class Place:
    """A position, both counted from 1, and the text that stands there."""

    line: int = 1
    column: int = 1
    text: str = ""

    @property
    def order(self) -> tuple[int, int]:
        """Sorts places as they stand in the file."""
        return self.line, self.column


@dataclass(frozen=True)
class Places:
    """Positions of keys and values by their path, e.g. ``("actuators", "cylinder", "line")``."""

    file: Path
    name: str = ""
    keys: dict[Keys, Place] = field(default_factory=dict)
    values: dict[Keys, Place] = field(default_factory=dict)

    def key(self, *path: str | int) -> Place:
        """Where a key stands; an element of a sequence has none, there it is the value."""
        return self.keys.get(path) or self.value(*path)

    def value(self, *path: str | int) -> Place:
        """Where a value stands, or the nearest stanza around it that is written."""
        while path and path not in self.values:
            path = path[:-1]
            if path in self.keys:
                return self.keys[path]
        return self.values.get(path, Place())

    def where(self, *path: str | int) -> str:
        """``file:line:column`` of a value."""
        place = self.value(*path)
        return f"{self.name or self.file}:{place.line}:{place.column}"
