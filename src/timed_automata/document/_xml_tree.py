"""XML elements with the file position of every character, which the standard library's trees do not keep."""

from __future__ import annotations

from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from dataclasses import dataclass, field
from typing import Any
from xml.parsers import expat

from timed_automata._limits import XML_DEPTH, XML_ELEMENTS
from timed_automata.document._text import Chunk, Text
from timed_automata.errors import ModelError


@dataclass(slots=True, eq=False)
class Element:
    """An XML element; ``text`` is its own character data, without the text of its children."""

    tag: str
    attributes: dict[str, str]
    place: Text
    children: list[Element] = field(default_factory=list)
    content: list[str] = field(default_factory=list)
    chunks: list[Chunk] = field(default_factory=list)

    @property
    def text(self) -> Text:
        """The character data with its position in the file."""
        place = self.place
        return Text("".join(self.content), place.file, self.chunks, place.encoding) if self.chunks else place

    def all(self, tag: str) -> list[Element]:
        """Return the children with that name."""
        return [child for child in self.children if child.tag == tag]

    def one(self, tag: str) -> Element | None:
        """Return the first child with that name, or None."""
        return next((child for child in self.children if child.tag == tag), None)


_MARKS = {BOM_UTF16_LE: "utf-16-le", BOM_UTF16_BE: "utf-16-be"}


class _Reader:
    def __init__(self, file: str, encoding: str) -> None:
        self.file, self.encoding = file, encoding
        self.parser = expat.ParserCreate()
        self.parser.buffer_text = False
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._characters
        self.parser.XmlDeclHandler = self._declaration
        self.parser.EntityDeclHandler = self._entity
        self.parser.AttlistDeclHandler = self._attribute
        self.root: Element | None = None
        self.open: list[Element] = []
        self._count = 0

    def _here(self, offset: int) -> Chunk:
        parser = self.parser
        return Chunk(
            offset, parser.CurrentLineNumber, parser.CurrentColumnNumber + 1, parser.CurrentByteIndex
        )

    def _declaration(self, _version: str, encoding: str | None, _standalone: int) -> None:
        if not self.encoding.startswith("utf-16"):  # where the mark at the start says more
            self.encoding = encoding or self.encoding

    def _entity(self, name: str, *_: Any) -> None:
        raise ModelError(
            f"The entity '{name}' is declared.", where=self._where(), todo="UPPAAL files have no entities."
        )

    def _attribute(self, _tag: str, name: str, _type: str, default: str | None, _required: int) -> None:
        if default is not None:  # each element would get a copy: some bytes of a file become gigabytes
            raise ModelError(
                f"The attribute '{name}' is declared with a default.",
                where=self._where(),
                todo="UPPAAL files have no such declarations.",
            )

    def _where(self) -> str:
        return f"{self.file}:{self.parser.CurrentLineNumber}:{self.parser.CurrentColumnNumber + 1}"

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self._count += 1
        if len(self.open) == XML_DEPTH or self._count > XML_ELEMENTS:
            deep = self._count <= XML_ELEMENTS
            what = (
                f"Elements are nested more than {XML_DEPTH} deep"
                if deep
                else f"More than {XML_ELEMENTS} elements"
            )
            raise ModelError(f"{what}.", where=self._where(), todo="UPPAAL does not write such a model.")
        element = Element(tag, attributes, Text("", self.file, [self._here(0)], self.encoding))
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.root = element
        self.open.append(element)

    def _end(self, _tag: str) -> None:
        self.open.pop()

    def _characters(self, data: str) -> None:
        element = self.open[-1]
        offset = element.chunks[-1].offset + len(element.content[-1]) if element.chunks else 0
        element.chunks.append(self._here(offset))
        element.content.append(data)


def read_xml(source: bytes, file: str) -> Element:
    """Parse XML and return the root element.

    Raises:
        ModelError: it is not well-formed XML, or incomplete.
    """
    reader = _Reader(file, _MARKS.get(source[:2], "utf-8"))
    try:
        reader.parser.Parse(source, True)
    except (expat.ExpatError, LookupError, ValueError) as error:
        if isinstance(error, ModelError):
            raise
        line, column = getattr(error, "lineno", 1), getattr(error, "offset", 0) + 1
        reason = expat.ErrorString(error.code) if isinstance(error, expat.ExpatError) else str(error)
        opened = reader.open[-1].tag if reader.open else None
        inside = f" inside <{opened}>" if opened else ""
        raise ModelError(
            f"This is not well-formed XML{inside}: {reason}.",
            where=f"{file}:{line}:{column}",
            todo="Is the file cut off? Save it again from UPPAAL.",
        ) from None
    if reader.root is None:  # pragma: no cover - expat reports an empty document itself
        raise ModelError("The file is empty.", where=f"{file}:1:1")
    return reader.root
