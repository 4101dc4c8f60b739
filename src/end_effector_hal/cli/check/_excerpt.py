"""The line of a file that a fault is about, with a mark under the offending text, as compilers show it."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from end_effector_hal.description import Fault
from end_effector_hal.errors import Diagnostic

WIDTH = 100
"""Columns of a line that are shown."""
LEAD = 40
"""Of them before the offending text, where the line is longer."""
LARGEST = 1_000_000


@dataclass(frozen=True)
class MarkedFault:
    """A fault, and what it is about.

    Attributes:
        diagnostic: the sentence with its place.
        line: of the file; None: it is read from the file.
        length: of the offending text in it.
    """

    diagnostic: Diagnostic
    line: str | None = None
    length: int = 1

    def excerpt(self) -> Iterator[str]:
        """Three lines: a gutter, the line of the file, the mark; none where there is no such line."""
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
    """A fault of a text that was read from the file of that name."""
    lines = text.split("\n")
    line = lines[fault.line - 1] if 0 < fault.line <= len(lines) else None
    return MarkedFault(fault.diagnostic(name), line, fault.length)


def _line_of(diagnostic: Diagnostic) -> str | None:
    path = Path(diagnostic.file)
    try:
        if not path.is_file() or path.stat().st_size > LARGEST:
            return None
        lines = path.read_text(encoding="utf-8", errors="replace").split("\n")
    except OSError:
        return None
    return lines[diagnostic.line - 1] if diagnostic.line <= len(lines) else None


def _shown(line: str, at: int, length: int) -> tuple[str, int, int]:
    """The line as a terminal shows it, cut to a width; columns before the mark, and columns of the mark."""
    line = line.rstrip()
    at, start = min(at, len(line)), 0
    if len(line) > WIDTH:
        start = max(0, min(at - LEAD, len(line) - WIDTH))
    end = start + WIDTH
    head, tail = "…" if start else "", "…" if len(line) > end else ""
    before = _columns(line[start:at]) + len(head)
    return head + _plain(line[start:end]) + tail, before, max(1, _columns(line[at : min(at + length, end)]))


def _plain(text: str) -> str:
    return "".join(each if each.isprintable() else " " if each.isspace() else "?" for each in text)


def _columns(text: str) -> int:
    """Of a terminal: wide characters take two, accents that stand alone none."""
    wide = sum(unicodedata.east_asian_width(each) in "WF" for each in text)
    return len(text) + wide - sum(bool(unicodedata.combining(each)) for each in text)
