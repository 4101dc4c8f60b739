"""A fault of a description, and its place in the file."""

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
    """A position in a file: line and column from 1, the short text there, its length in its first line.

    ``path`` holds the keys that were looked up: a default that is not written has the place of the stanza around it.
    A place in the file of a device has the name of that ``file``, and the place in the description that ``uses`` it.
    """

    line: int = 1
    column: int = 1
    text: str = ""
    length: int = 1
    path: Keys = ()
    file: str = ""
    uses: str = ""

    @property
    def order(self) -> tuple[int, int]:
        """Sort key for the order of the file."""
        return self.line, self.column


@dataclass(frozen=True)
class UsedDevice:
    """A device of the library that an actuator uses.

    Attributes:
        name, title: its name in the library, and the words of its file.
        file: path of its file.
        confirmed: how its registers are confirmed: maker, drivers or no.
        channels: names of its channels in the description.
        overridden: keys that the description writes instead of the device's, such as ``actuators.fingers.timeout_s``.
    """

    name: str
    title: str
    file: Path
    confirmed: str
    channels: tuple[str, ...] = ()
    overridden: tuple[str, ...] = ()


@dataclass(frozen=True)
class Places:
    """Positions of keys and values by their path, e.g. ``("actuators", "cylinder", "line")``.

    ``devices`` holds the devices of the library by the actuator that uses them.
    """

    file: Path
    name: str = ""
    keys: dict[Keys, Place] = field(default_factory=dict)
    values: dict[Keys, Place] = field(default_factory=dict)
    devices: dict[str, UsedDevice] = field(default_factory=dict)

    def key(self, *path: str | int) -> Place:
        """Return the place of a key; for an element of a list, which has no key, that of its value."""
        found = self.keys.get(path)
        return replace(found, path=path) if found else self.value(*path)

    def value(self, *path: str | int) -> Place:
        """Return the place of a value; if it is not written, that of the nearest written stanza around it."""
        around = path
        while around and around not in self.values:
            around = around[:-1]
            if around in self.keys:
                return replace(self.keys[around], path=path)
        return replace(self.values.get(around, Place()), path=path)

    def for_part(self, name: str) -> Places:
        """Return the places of the tool as it grips a part: its actuators' keys stand under the part."""
        prefix = ("parts", name, "actuators")

        def moved(places: dict[Keys, Place]) -> dict[Keys, Place]:
            own = {path[2:]: place for path, place in places.items() if path[:3] == prefix and len(path) > 4}
            return {**places, **own}

        return replace(self, keys=moved(self.keys), values=moved(self.values))

    def where(self, *path: str | int) -> str:
        """Return the place of a value as ``file:line:column``."""
        place = self.value(*path)
        return f"{place.file or self.name or self.file}:{place.line}:{place.column}"


#: Stable codes; ``docs/reference/errors.md`` lists them.
CODES = {
    "EE-201": "the file cannot be read",
    "EE-202": "not YAML",
    "EE-203": "YAML that a description does not use: tags, merge keys, several documents, a list at the top",
    "EE-204": "a key is repeated",
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
    "EE-227": "a condition that makes no sense",
    "EE-228": "channels and the frame of the link do not go together",
    "EE-229": "an output on the bus that makes no sense",
    "EE-230": "a device of the library that is unknown, or cannot be used",
}


@dataclass(frozen=True, order=True)
class Fault:
    """A fault: what is wrong, where, the text found there, and what is expected.

    Line and column are counted from 1; line 0 means the whole file.
    """

    line: int
    column: int
    code: str
    what: str
    found: str = ""
    expected: str = ""
    hint: str = ""
    length: int = field(default=1, compare=False)
    """Length of the offending text in its line."""
    path: Keys = field(default=(), compare=False)
    """Keys that lead to the offending value; () if the fault belongs to no key or value."""
    file: str = ""
    """Name of the file if it is not the description: that of a device."""
    uses: str = ""
    """Place in the description that uses this device."""

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
        """Return a fault at a place; the offending text is that of the place unless ``found`` is given."""
        found = place.text if found is None else found
        return cls(
            place.line,
            place.column,
            code,
            what,
            found,
            expected,
            hint,
            place.length,
            place.path,
            place.file,
            place.uses,
        )

    @property
    def message(self) -> str:
        """The sentence without its place: what is wrong (offending text), expected …; hint."""
        found = f" ({self.found})" if self.found else ""
        expected = f", expected {self.expected}" if self.expected else ""
        hint = f"; {self.hint}" if self.hint else ""
        uses = f"; used at {self.uses}" if self.uses else ""
        return escaped(f"{self.what}{found}{expected}{hint}{uses}")

    def diagnostic(self, name: str) -> Diagnostic:
        """Return the fault as a diagnostic of this file; as text ``file:line:column: message [code]``."""
        return Diagnostic(self.code, self.file or name, self.line, self.column, self.message)


def closest(word: object, candidates: Iterable[str]) -> str | None:
    """Return the candidate that the author of ``word`` probably meant; None: no candidate is similar."""
    written = str(word).lower()
    known = {each.lower(): each for each in candidates if not _another_number(written, each.lower())}
    matches = get_close_matches(written, known, n=1, cutoff=0.6)
    return known[matches[0]] if matches else None


def _another_number(word: str, candidate: str) -> bool:
    """Return whether two words differ only in their digits: IL-02 is not a misspelt IL-09."""
    return word != candidate and re.sub(r"\d", "0", word) == re.sub(r"\d", "0", candidate)


def did_you_mean(word: object, candidates: Iterable[str]) -> str:
    """Return a hint such as ``did you mean 'line'?``; empty if no candidate is similar."""
    match = closest(word, candidates)
    return f"did you mean {match!r}?" if match and match != word else ""
