"""One thing that is wrong with a description, and the place in its file."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING

from end_effector_hal.errors import Diagnostic
from end_effector_hal.vocabulary import escaped

if TYPE_CHECKING:
    from collections.abc import Iterable


Keys = tuple[str | int, ...]


@dataclass(frozen=True)
class Place:
    """A position, both counted from 1, the text that stands there in short, and its length in its first line.

    ``path`` is what was looked for: a default that is not written has the place of the stanza around it.
    """

    line: int = 1
    column: int = 1
    text: str = ""
    length: int = 1
    path: Keys = ()

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
        found = self.keys.get(path)
        return replace(found, path=path) if found else self.value(*path)

    def value(self, *path: str | int) -> Place:
        """Where a value stands, or the nearest stanza around it that is written."""
        around = path
        while around and around not in self.values:
            around = around[:-1]
            if around in self.keys:
                return replace(self.keys[around], path=path)
        return replace(self.values.get(around, Place()), path=path)

    def where(self, *path: str | int) -> str:
        """``file:line:column`` of a value."""
        place = self.value(*path)
        return f"{self.name or self.file}:{place.line}:{place.column}"


#: Stable codes; ``docs/reference/description.md`` lists them.
CODES = {
    "EE-201": "the file cannot be read",
    "EE-202": "not YAML",
    "EE-203": "YAML that a description does not use: tags, merge keys, several documents, a list at the top",
    "EE-204": "a key stands twice",
    "EE-205": "unknown key",
    "EE-206": "missing key",
    "EE-207": "wrong type",
    "EE-208": "out of range",
    "EE-209": "not one of the choices",
    "EE-210": "wrong unit",
    "EE-211": "text of the wrong form",
    "EE-220": "sequence or release order does not fit the actuators",
    "EE-221": "two devices share a line, a channel, a bit, a service or a topic",
    "EE-222": "thresholds or times in the wrong order",
    "EE-223": "an ending would release a held part",
    "EE-224": "the automata file is missing",
    "EE-225": "no wire carries a channel, or the codec cannot prove an actuator",
    "EE-226": "unknown codec",
    "EE-227": "a condition that cannot be meant",
    "EE-228": "channels and the frame of the link do not go together",
    "EE-229": "an output on the bus that cannot be meant",
}


@dataclass(frozen=True, order=True)
class Fault:
    """What is wrong, where (counted from 1; line 0: the whole file), what stands there, what is expected."""

    line: int
    column: int
    code: str
    what: str
    found: str = ""
    expected: str = ""
    hint: str = ""
    length: int = field(default=1, compare=False)
    """Of the offending text, in its line."""
    path: Keys = field(default=(), compare=False)
    """Keys that lead to it; () where it is none of a key or value."""

    @classmethod
    def at(
        cls,
        place: Place,
        code: str,
        what: str,
        *,
        expected: str = "",
        hint: str = "",
        found: str | None = None,
    ) -> Fault:
        """A fault at a place, whose text is the offending text unless ``found`` is given."""
        found = place.text if found is None else found
        return cls(place.line, place.column, code, what, found, expected, hint, place.length, place.path)

    @property
    def message(self) -> str:
        """The sentence without its place: what (offending text), expected …; hint."""
        found = f" ({self.found})" if self.found else ""
        expected = f", expected {self.expected}" if self.expected else ""
        hint = f"; {self.hint}" if self.hint else ""
        return escaped(f"{self.what}{found}{expected}{hint}")

    def diagnostic(self, name: str) -> Diagnostic:
        """The fault of the file that is called so; as text ``file:line:column: message [code]``."""
        return Diagnostic(self.code, name, self.line, self.column, self.message)


def closest(word: object, candidates: Iterable[str]) -> str | None:
    """The candidate that somebody who wrote ``word`` probably meant."""
    written = str(word).lower()
    known = {each.lower(): each for each in candidates if not _another_number(written, each.lower())}
    matches = get_close_matches(written, known, n=1, cutoff=0.6)
    return known[matches[0]] if matches else None


def _another_number(word: str, candidate: str) -> bool:
    """IL-02 is no misspelt IL-09."""
    return word != candidate and re.sub(r"\d", "0", word) == re.sub(r"\d", "0", candidate)


def did_you_mean(word: object, candidates: Iterable[str]) -> str:
    """A hint, or nothing if no candidate is near."""
    match = closest(word, candidates)
    return f"did you mean {match!r}?" if match and match != word else ""
