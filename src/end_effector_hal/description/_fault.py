"""One thing that is wrong with a description, and where."""

from __future__ import annotations

import re
from dataclasses import dataclass
from difflib import get_close_matches
from typing import TYPE_CHECKING

from end_effector_hal.errors import Diagnostic

if TYPE_CHECKING:
    from collections.abc import Iterable

    from ._places import Place

#: Stable codes; ``docs/description.md`` lists them.
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
        return cls(
            place.line, place.column, code, what, place.text if found is None else found, expected, hint
        )

    @property
    def message(self) -> str:
        """The sentence without its place: what (offending text), expected …; hint."""
        found = f" ({self.found})" if self.found else ""
        expected = f", expected {self.expected}" if self.expected else ""
        hint = f"; {self.hint}" if self.hint else ""
        return printable(f"{self.what}{found}{expected}{hint}")

    def diagnostic(self, name: str) -> Diagnostic:
        """The fault of the file that is called so; as text ``file:line:column: message [code]``."""
        return Diagnostic(self.code, name, self.line, self.column, self.message)


def printable(text: str) -> str:
    """With escapes for what no terminal shows, so that a sentence stays one line."""
    return "".join(each if each.isprintable() else repr(each)[1:-1] for each in text)


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
    return f"did you mean {match!r}?" if match else ""
