"""The line of a file that contains a fault, with a mark under the offending text, as compilers show it."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from end_effector_hal.description import Fault
from end_effector_hal.errors import Diagnostic

WIDTH = 100
"""Largest part of a line that is shown, columns."""
LEAD = 40
"""Columns shown before the offending text if the line is longer than WIDTH."""
LARGEST = 1_000_000


@dataclass(frozen=True)
class MarkedFault:
    """A fault with the offending text in its file.

    Attributes:
        diagnostic: the sentence with its place.
        line: the line of the file; None to read it from the file.
        length: length of the offending text in the line.
    """

    diagnostic: Diagnostic
    line: str | None = None
    length: int = 1

    def excerpt(self) -> Iterator[str]:
        """Yield three lines: a gutter, the line of the file, the mark; nothing if there is no such line."""
        if not self.diagnostic.line:
            return
        line = self.line if self.line is not None else _line_of(self.diagnostic)
        if line is None:
            return
        number, gutter = str(self.diagnostic.line), " " * len(str(self.diagnostic.line))
        shown, before, marks = _shown(line, self.diagnostic.column - 1, self.length)
        yield f"{gutter} |"
        yield f"{number} | {shown}".rstrip()
        yield f"{gutter} | {' ' * before}{'^' * marks}"


def marked(fault: Fault, name: str, text: str) -> MarkedFault:
    """Return a fault of a text that was read from the file of that name, with its line; empty: it is no text."""
    if fault.file:
        return MarkedFault(fault.diagnostic(name), None, fault.length)
    lines = text.split("\n")
    line = lines[fault.line - 1] if text and 0 < fault.line <= len(lines) else None
    return MarkedFault(fault.diagnostic(name), line, fault.length)


def _line_of(diagnostic: Diagnostic) -> str | None:
    path = Path(diagnostic.file)
    try:
        if not path.is_file() or path.stat().st_size > LARGEST:
            return None
        lines = path.read_text(encoding="utf-8", errors="surrogateescape").split("\n")
    except OSError:
        return None
    return lines[diagnostic.line - 1] if diagnostic.line <= len(lines) else None


def _shown(line: str, at: int, length: int) -> tuple[str, int, int]:
    """Return the line as a terminal shows it, cut to a width; the columns before the mark; and the columns of the
    mark.
    """
    line = line.rstrip()
    lead, meant, rest = _plain(line[:at]), _plain(line[at : at + length]), _plain(line[at + length :])
    line, at, length, start = lead + meant + rest, len(lead), len(meant), 0
    if len(line) > WIDTH:
        start = max(0, min(at - LEAD, len(line) - WIDTH))
    end = start + WIDTH
    head, tail = "…" if start else "", "…" if len(line) > end else ""
    before = _columns(line[start:at]) + len(head)
    return head + line[start:end] + tail, before, max(1, _columns(line[at : min(at + length, end)]))


def _plain(text: str) -> str:
    return "".join(each if each.isprintable() else " " if each.isspace() else _escaped(each) for each in text)


def _escaped(character: str) -> str:
    """Return what is not printable as an escape, such as ``\\x1b``; a byte that is no text is a lone surrogate here."""
    code = ord(character)
    return f"\\x{code - 0xDC00:02x}" if 0xDC80 <= code <= 0xDCFF else repr(character)[1:-1]


def _columns(text: str) -> int:
    """Return the width of a text on a terminal: wide characters count as two columns, combining accents as none."""
    wide = sum(unicodedata.east_asian_width(each) in "WF" for each in text)
    return len(text) + wide - sum(bool(unicodedata.combining(each)) for each in text)
