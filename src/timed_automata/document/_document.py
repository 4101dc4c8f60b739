"""The parts of a UPPAAL file, including layout, comments and queries; their texts keep their position."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from timed_automata.document._text import Text


@dataclass(frozen=True, slots=True)
class Point:
    """A point on UPPAAL's canvas, in pixels; y grows downwards."""

    x: int
    y: int


@dataclass(frozen=True, slots=True)
class Label:
    """A text on the canvas: a guard, an invariant, a comment, a name, …"""

    kind: str
    text: Text
    at: Point | None


@dataclass(frozen=True, slots=True)
class DrawnLocation:
    """A location as drawn in the file."""

    id: str
    name: Label | None
    at: Point | None
    labels: Mapping[str, Label]
    urgent: bool
    committed: bool
    color: str | None
    place: Text  # empty: where the element starts


@dataclass(frozen=True, slots=True)
class DrawnEdge:
    """An edge as drawn in the file, with its bend points ("nails")."""

    source: str
    target: str
    labels: Mapping[str, Label]
    nails: tuple[Point, ...]
    color: str | None
    place: Text


@dataclass(frozen=True, slots=True)
class Template:
    """A template as written in the file."""

    name: Text
    parameters: Text | None
    declarations: Text | None
    locations: tuple[DrawnLocation, ...]
    edges: tuple[DrawnEdge, ...]
    initial: str
    place: Text


@dataclass(frozen=True, slots=True)
class StoredQuery:
    """A query that is stored with the model, and its comment."""

    formula: Text
    comment: str


@dataclass(frozen=True, slots=True)
class Note:
    """A part of a file that has no meaning for this package and is ignored."""

    what: str
    where: str

    def __str__(self) -> str:
        return f"{self.where}: {self.what}"


@dataclass(frozen=True, slots=True)
class Document:
    """A UPPAAL file; ``source`` is the content of the file, byte for byte, and writing starts from it."""

    path: str
    source: bytes = field(repr=False)
    declarations: Text | None
    templates: tuple[Template, ...]
    instantiations: Text | None
    system: Text
    queries: tuple[StoredQuery, ...]
    notes: tuple[Note, ...] = ()
