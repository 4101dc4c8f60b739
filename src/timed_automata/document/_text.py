"""Pieces of model text with their position in the file, and faults worded with ``file:line:column``."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from typing import NamedTuple

from timed_automata.errors import ModelError


class Chunk(NamedTuple):
    """A run of characters of a text that is contiguous on one line of the file."""

    offset: int  # in the text
    line: int
    column: int
    byte: int  # in the file


class Text:
    """The text of one XML element; it keeps the position of every character in the file.

    Entities (``&lt;``), CDATA and line ends make a text shorter than its place in the file; therefore it consists of
    chunks.
    """

    def __init__(self, content: str, file: str, chunks: list[Chunk], encoding: str = "utf-8") -> None:
        self.content, self.file, self.encoding = content, file, encoding
        self._chunks = chunks or [Chunk(0, 1, 1, 0)]
        self._offsets = [chunk.offset for chunk in self._chunks]

    @classmethod
    def plain(cls, content: str, file: str) -> Text:
        """Return a text that comes from no model file: a query typed by a user, or a test."""
        chunks, offset, byte = [], 0, 0
        for number, line in enumerate(content.split("\n"), start=1):
            chunks.append(Chunk(offset, number, 1, byte))
            offset += len(line) + 1
            byte += len(line.encode()) + 1
        return cls(content, file, chunks)

    def __repr__(self) -> str:
        return f"<Text {self.content[:40]!r} at {self.where(0)}>"

    def _chunk(self, offset: int) -> Chunk:
        return self._chunks[max(0, bisect_right(self._offsets, offset) - 1)]

    def where(self, offset: int) -> str:
        """Return ``file:line:column`` of a character; line and column count from one."""
        chunk = self._chunk(offset)
        return f"{self.file}:{chunk.line}:{chunk.column + offset - chunk.offset}"

    def byte(self, offset: int) -> int:
        """Return the byte offset of a character in the file, for splicing."""
        chunk = self._chunk(offset)
        return chunk.byte + len(self.content[chunk.offset : offset].encode(self.encoding))

    def cut(self, start: int, end: int) -> Text:
        """Return a part as a text of its own, with its position in the file."""
        chunks = [
            Chunk(max(0, chunk.offset - start), chunk.line, column, byte)
            for chunk, following in zip(
                self._chunks, [*self._offsets[1:], len(self.content) + 1], strict=True
            )
            if chunk.offset < end and following > start
            for shift in [max(0, start - chunk.offset)]
            for column, byte in [(chunk.column + shift, self.byte(chunk.offset + shift))]
        ]
        return Text(self.content[start:end], self.file, chunks, self.encoding)

    def without_comments(self) -> Text:
        """Return the text with spaces in place of comments, for queries, which are split before they are parsed."""
        content = re.sub(
            r"//[^\n]*|/\*[\s\S]*?\*/", lambda found: re.sub(r"[^\n]", " ", found[0]), self.content
        )
        return self if content == self.content else Text(content, self.file, self._chunks, self.encoding)

    @property
    def whole(self) -> Span:
        """The whole text as a span."""
        return Span(self, 0, len(self.content))


@dataclass(frozen=True, slots=True, eq=False)
class Span:
    """The part of a text from which a node of the syntax tree was read."""

    text: Text
    start: int
    end: int

    @property
    def where(self) -> str:
        """``file:line:column`` of its first character."""
        return self.text.where(self.start)

    @property
    def snippet(self) -> str:
        """The source on one line, shortened to at most 60 characters for messages."""
        source = " ".join(self.text.content[self.start : self.end].split())
        return source if len(source) <= 60 else source[:57] + "..."

    def __repr__(self) -> str:
        return f"<{self.where} {self.snippet!r}>"


def fault(span: Span, what: str, todo: str = "") -> ModelError:
    """Return a ModelError at the span."""
    return ModelError(what, where=span.where, todo=todo)


def refused(span: Span, construct: str, todo: str) -> ModelError:
    """Return the error for a construct that UPPAAL supports and this subset does not, and what to write instead."""
    return fault(span, f"{construct}: outside of the supported subset.", todo)


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return ``Did you mean …?`` with the closest known name, or an empty string."""
    close = get_close_matches(name, sorted(set(known)), n=1, cutoff=0.6)
    return f"Did you mean '{close[0]}'?" if close else ""
