"""A UPPAAL file as an XML document whose texts keep their position, and the wording of faults."""

from ._document import Document, DrawnEdge, DrawnLocation, Label, StoredQuery, Template
from ._text import Span, Text, did_you_mean, fault, refused
from ._xml_file import load_document, load_source, read_document, write_document

__all__ = [
    "Document",
    "DrawnEdge",
    "DrawnLocation",
    "Label",
    "Span",
    "StoredQuery",
    "Template",
    "Text",
    "did_you_mean",
    "fault",
    "load_document",
    "load_source",
    "read_document",
    "refused",
    "write_document",
]
