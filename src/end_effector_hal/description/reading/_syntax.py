"""Turns the errors of the YAML reader into faults with helpful messages."""

from __future__ import annotations

import re
from bisect import bisect_right
from typing import TYPE_CHECKING

from ruamel.yaml.reader import ReaderError

from end_effector_hal.description._fault import Fault
from end_effector_hal.vocabulary import escaped

if TYPE_CHECKING:
    from ruamel.yaml.error import MarkedYAMLError


# (pattern of the reader's words, what, expected, whether to point at the start of the construct)
SENTENCES = (
    (r"character '\\t'", "a tab", "spaces to indent", False),
    (r"character '%'", "a text begins with '%'", "quotes around it", False),
    (r"character '[@`]'", "a text begins with a reserved character", "quotes around it", False),
    (r"mapping values are not allowed", "a ':' too many", "quotes around a text with ': ' in it", False),
    (r"could not find expected ':'", "a line without ':'", "key: value", True),
    (
        r"expected <block end>",
        "the indentation fits no line above",
        "the keys of a stanza in one column",
        False,
    ),
    (r"unexpected (end of stream|document sep)", "a quote is not closed", "the closing quote", True),
    (r"expected ',' or '\]'", "a bracket is not closed, or a comma is missing", "[a, b, c]", True),
    (r"expected ',' or '\}'", "a brace is not closed, or a comma is missing", "{key: value, …}", True),
    (r"<stream end>", "the file ends too early", "the rest of it", False),
    (r"undefined alias", "an alias that no anchor defines", "an &anchor above it", False),
    (r"another document", "a second document", "one; '---' stands at the top only", False),
    (r"unknown escape character", "an unknown escape in a quoted text", "single quotes", False),
    (r"maximum depth", "nested too deep", "a few levels", False),
)


def syntax_fault(error: MarkedYAMLError | ReaderError, text: str) -> Fault:
    """Return the fault that stopped the reader."""
    if isinstance(error, ReaderError):
        line, column = position(text, error.position)
        found = f"U+{error.character:04X}" if isinstance(error.character, int) else ""
        return Fault(line, column, "EE-202", "not YAML: a character that cannot be printed", found, "text")
    mark, what, expected = error.problem_mark or error.context_mark, shorten(str(error.problem), 80), ""
    for pattern, sentence, better, at_start in SENTENCES:
        if re.search(pattern, what):
            what, expected = sentence, better
            mark = error.context_mark if at_start and error.context_mark else mark
            break
    index = min(getattr(mark, "index", 0), len(text))
    found = text[text.rfind("\n", 0, index) + 1 :].split("\n", 1)[0]
    line, column = position(text, index)
    return Fault(line, column, "EE-202", f"not YAML: {what}", shorten(found) or "end of the file", expected)


class LineStarts:
    """Converts indexes of one text to positions without reading the text again each time."""

    def __init__(self, text: str) -> None:
        self._starts = [0, *(match.end() for match in re.finditer("\n", text))]

    def position(self, index: int) -> tuple[int, int]:
        """Return the line and the column of an index, both counted from 1."""
        line = bisect_right(self._starts, index)
        return line, index - self._starts[line - 1] + 1


def position(text: str, index: int) -> tuple[int, int]:
    """Return the line and the column of an index, both counted from 1."""
    return text.count("\n", 0, index) + 1, index - text.rfind("\n", 0, index)


def shorten(text: str, width: int = 40) -> str:
    """Return the first line of a text, printable and not longer than ``width``."""
    lines = text.strip().splitlines() or [""]
    line = escaped(lines[0].rstrip())
    return line if len(line) <= width and len(lines) == 1 else line[: width - 1].rstrip() + "…"
